// What the register-map model shows to a reader: identity, status, positions.

#include <algorithm>
#include <cmath>

#include "sim/controller/modbus_controller.h"

namespace tiltfeed::sim {
namespace {

constexpr std::uint16_t kMapVersion = 1;
constexpr std::uint16_t kCapabilities = 0b1111;  // FC23, ring, positions, kept axes and machine coordinates
constexpr std::uint16_t kAxisMask = 0b11111;
constexpr std::uint16_t kDecimalExponent = 4;
constexpr std::size_t kMostReadWords = 125;

void put_pair(std::span<std::uint16_t> words, std::size_t at, std::uint32_t value) {
  words[at] = static_cast<std::uint16_t>(value >> 16);
  words[at + 1] = static_cast<std::uint16_t>(value);
}

std::uint32_t position_word(double value) {
  const double units = std::clamp(std::round(value * kPositionScale), -2147483648.0, 2147483647.0);
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(units));
}

}  // namespace

Access ModbusController::readable(std::uint16_t address, std::size_t count) {
  if (count < 1 || count > kMostReadWords) return Access::kIllegalValue;
  const auto within = [&](std::uint16_t first, std::uint16_t words) {
    return address >= first && address + count <= static_cast<std::size_t>(first) + words;
  };
  return within(kIdentityAt, kIdentityWords) || within(kStatusAt, kStatusWords) ||
                 within(kPositionsAt, kPositionsWords)
             ? Access::kOk
             : Access::kIllegalAddress;
}

Access ModbusController::read(std::uint16_t address, std::span<std::uint16_t> words) {
  if (const Access access = readable(address, words.size()); access != Access::kOk) return access;
  const auto copy = [&](const auto& area, std::uint16_t first) {
    std::copy_n(area.begin() + (address - first), words.size(), words.begin());
  };
  if (address >= kPositionsAt) {
    copy(positions(), kPositionsAt);
  } else if (address >= kStatusAt) {
    ++status_seq_;
    copy(status(), kStatusAt);
  } else {
    copy(identity(), kIdentityAt);
  }
  return Access::kOk;
}

RunState ModbusController::state() const {
  if (alarm_ != 0) return RunState::kAlarm;
  if (session_ == 0) return RunState::kNoSession;
  if (motion_.held()) return RunState::kHold;
  if (!motion_.idle()) return RunState::kRunning;
  return done_ ? RunState::kDone : RunState::kIdle;
}

std::array<std::uint16_t, kStatusWords> ModbusController::status() const {
  std::array<std::uint16_t, kStatusWords> words{};
  words[0] = status_seq_;
  words[1] = boot_id_;
  words[2] = session_;
  words[3] = last_accepted_;
  words[4] = last_started_;
  words[5] = last_completed_;
  words[6] = static_cast<std::uint16_t>(motion_.free_slots());
  words[7] = static_cast<std::uint16_t>(state());
  words[8] = alarm_;
  words[9] = static_cast<std::uint16_t>(nack_);
  words[10] = nack_seq_;
  words[11] = cmd_ack_;
  words[12] = cmd_result_;
  words[13] = static_cast<std::uint16_t>(motion_.feed_override());
  words[14] = heartbeat_;
  const Block* running = motion_.running();
  put_pair(words, 15, running != nullptr ? running->line : 0);
  words[23] = status_seq_;
  return words;
}

std::array<std::uint16_t, kIdentityWords> ModbusController::identity() const {
  return {kMagic,           kMapVersion,      kCapabilities, static_cast<std::uint16_t>(motion_.slots()),
          kBlockWords,      kBlocksPerWindow, kAxisMask,     kDecimalExponent,
          kDecimalExponent, boot_id_};
}

std::array<std::uint16_t, kPositionsWords> ModbusController::positions() const {
  const Joints at = motion_.position();
  std::array<std::uint16_t, kPositionsWords> words{};
  std::size_t word = 0;
  for (const double axis : {at.x, at.y, at.z, at.a, at.c}) {
    put_pair(words, word, position_word(axis));
    word += 2;
  }
  return words;
}

}  // namespace tiltfeed::sim
