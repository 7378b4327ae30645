#include "daemon/protocol/drive_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace tiltfeed::daemon {

namespace {

constexpr std::array<const char*, 5> kAxisNames{"X", "Y", "Z", "the tilt axis", "the rotary axis"};
constexpr double kMostSpeed = 65535.0;

std::array<double, 5> axes_of(const NumericBlock& block) {
  return {block.x, block.y, block.z, block.tilt, block.rotary};
}

bool moves(const NumericBlock& block) { return block.op == BlockOp::kRapid || block.op == BlockOp::kFeed; }

/// Spindle and coolant are no part of such a drive; the rest of M waits or ends.
bool switches(int m_code) { return m_code >= 3 && m_code <= 9 && m_code != 6; }

}  // namespace

Result<std::vector<std::uint16_t>> DriveEncoder::encode(const NumericBlock& block) {
  if (block.op == BlockOp::kMCode && switches(block.m_code))
    return fail(Code::kInput, "a plain drive moves axes only: take M" + std::to_string(block.m_code) +
                                  " out of the program and switch by hand");
  if (!moves(block)) return std::vector<std::uint16_t>{};
  const std::array<double, 5> to = axes_of(block);
  const auto stays = [&](std::size_t axis) { return (block.kept >> axis & 1U) != 0; };
  bool any = false;
  for (std::size_t i = 0; i < to.size(); ++i) any = any || (map_.axes[i].word >= 0 && !stays(i));
  if (!any && block.kept != 0) return std::vector<std::uint16_t>{};
  if (block.machine)
    return fail(Code::kInput,
                "a plain drive has no machine coordinates; post with the profile's `retract: none`");
  std::vector<std::uint16_t> words(static_cast<std::size_t>(map_.words), 0);
  for (std::size_t i = 0; i < to.size(); ++i) {
    const config::DriveAxis& axis = map_.axes[i];
    if (axis.word < 0) {
      if (before_ && !stays(i) && (before_->kept >> i & 1U) == 0 && axes_of(*before_)[i] != to[i])
        return fail(Code::kInput, std::string(kAxisNames[i]) +
                                      " moves, and wire.drive of the profile has no registers for it");
      continue;
    }
    if (stays(i))
      return fail(Code::kInput, std::string("one write moves all axes of the drive, and the program has not "
                                            "said yet where ") +
                                    kAxisNames[i] + " shall be");
    const double counts = std::round(to[i] * axis.counts);
    if (!(std::abs(counts) <= std::numeric_limits<std::int32_t>::max()))
      return fail(Code::kLimit, std::string(kAxisNames[i]) + " does not fit the drive's 32-bit register");
    const auto bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(counts));
    const auto high = static_cast<int>(bits >> 16), low = static_cast<int>(bits & 0xFFFF);
    put(words, axis.word, map_.low_word_first ? low : high);
    put(words, axis.word + 1, map_.low_word_first ? high : low);
  }
  const Result<double> speed = this->speed(block);
  if (!speed) return tl::unexpected<Error>(speed.error());
  const double counts = std::max(1.0, std::round(*speed * map_.feed_counts));
  if (map_.feed_word >= 0 && !(counts <= kMostSpeed))
    return fail(Code::kLimit,
                "the speed " + std::to_string(*speed) + " per minute does not fit the drive's register");
  put(words, map_.feed_word, map_.feed_word >= 0 ? static_cast<int>(counts) : 0);
  put(words, map_.mode_word, map_.mode);
  put(words, map_.acceleration_word, map_.acceleration);
  put(words, map_.deceleration_word, map_.deceleration);
  words.back() = static_cast<std::uint16_t>(map_.trigger);
  before_ = block;
  return words;
}

void DriveEncoder::put(std::vector<std::uint16_t>& words, int place, int value) const {
  if (place >= 0) words[static_cast<std::size_t>(place)] = static_cast<std::uint16_t>(value);
}

/// Along X Y Z, or of the rotary axes where these stand; mm or degrees a minute.
Result<double> DriveEncoder::speed(const NumericBlock& block) const {
  if (block.op == BlockOp::kRapid) return map_.rapid;
  if (!block.inverse_time) return block.feed;
  if (!before_)
    return fail(Code::kInput, "the first move states its time (G93), and not from where it begins");
  const double way = std::hypot(block.x - before_->x, block.y - before_->y, block.z - before_->z);
  const double turn = std::hypot(block.tilt - before_->tilt, block.rotary - before_->rotary);
  return block.feed * (way > 0.0 ? way : turn);
}

}  // namespace tiltfeed::daemon
