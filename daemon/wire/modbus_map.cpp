#include "daemon/wire/modbus_map.h"

#include <zlib.h>

#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>

namespace tiltfeed::daemon {

namespace {

constexpr int kMaxExponent = 6;  // 1e-6 mm in 32 bits still spans 2 m
constexpr double kThousandths = 1000.0;
constexpr std::size_t kCrcWord = 4, kFirstBlockWord = 6;

void append_word(std::string& bytes, std::uint16_t word) {
  bytes += static_cast<char>(word >> 8);
  bytes += static_cast<char>(word & 0xFF);
}

std::uint16_t word_at(std::string_view bytes, std::size_t index) {
  return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[2 * index]) << 8 |
                                    static_cast<unsigned char>(bytes[2 * index + 1]));
}

void put_long(std::uint16_t* at, std::uint32_t value, bool low_word_first) {
  at[low_word_first ? 1 : 0] = static_cast<std::uint16_t>(value >> 16);
  at[low_word_first ? 0 : 1] = static_cast<std::uint16_t>(value & 0xFFFF);
}

/// CRC-32 (IEEE 802.3, as zlib) over all words but the two that hold it.
std::uint32_t crc_without(std::span<const std::uint16_t> words, std::size_t hole) {
  std::string bytes;
  bytes.reserve(2 * words.size());
  for (std::size_t i = 0; i < words.size(); ++i)
    if (i != hole && i != hole + 1) append_word(bytes, words[i]);
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

Result<std::uint32_t> scaled(const char* name, double value, double scale, double min, double max) {
  const double counts = std::round(value * scale);
  if (counts >= min && counts <= max) return static_cast<std::uint32_t>(static_cast<std::int64_t>(counts));
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, value);
  return fail(Code::kLimit, std::string(name) + std::string(digits, end.ptr) +
                                " does not fit the controller's 32-bit word");
}

}  // namespace

Result<RingIdentity> parse_identity(std::span<const std::uint16_t> words) {
  if (words.size() != kIdentityWords || words[0] != kMagic)
    return fail(Code::kLink, "no ring controller at this address (identity word is " +
                                 std::to_string(words.empty() ? 0 : words[0]) + ", not 0x5446)");
  if (words[1] != kMapVersion)
    return fail(Code::kLink, "the controller has map version " + std::to_string(words[1]) + ", this is 1");
  RingIdentity identity;
  identity.fc23 = (words[2] & 1) != 0;
  identity.keeps = (words[2] & 8) != 0;
  identity.positions = (words[2] & 4) != 0;
  identity.slots = words[3];
  identity.linear_exponent = words[7];
  identity.rotary_exponent = words[8];
  identity.boot_id = words[9];
  if ((words[2] & 2) == 0 || identity.slots < 1 || words[4] != kBlockWords || words[5] != kWindowBlocks)
    return fail(Code::kLink, "the controller has no ring of 16-word blocks, 7 to a write");
  if (identity.linear_exponent > kMaxExponent || identity.rotary_exponent > kMaxExponent)
    return fail(Code::kLink, "the controller's position scale is finer than 1e-6");
  return identity;
}

std::array<double, 5> parse_positions(std::span<const std::uint16_t> words, const RingIdentity& scale,
                                      bool low_word_first) {
  assert(words.size() == kPositionsWords);
  std::array<double, 5> axes{};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::uint32_t high = words[2 * i + (low_word_first ? 1 : 0)];
    const std::uint32_t low = words[2 * i + (low_word_first ? 0 : 1)];
    const int exponent = i < 3 ? scale.linear_exponent : scale.rotary_exponent;
    axes[i] = static_cast<std::int32_t>(high << 16 | low) / std::pow(10.0, exponent);
  }
  return axes;
}

RingStatus parse_ring_status(std::span<const std::uint16_t> w, bool low_word_first) {
  assert(w.size() == kStatusWords);
  RingStatus status;
  status.status_seq = w[0];
  status.boot_id = w[1];
  status.session = w[2];
  status.last_accepted = w[3];
  status.last_started = w[4];
  status.last_completed = w[5];
  status.free_slots = w[6];
  status.state = static_cast<RingState>(w[7]);
  status.alarm = w[8];
  status.nack = static_cast<Nack>(w[9]);
  status.nack_seq = w[10];
  status.command_ack = w[11];
  status.command_result = w[12];
  status.feed_override = w[13];
  status.heartbeat = w[14];
  const std::size_t high = low_word_first ? 16 : 15, low = low_word_first ? 15 : 16;
  status.line = static_cast<std::uint32_t>(w[high]) << 16 | w[low];
  status.torn = w[0] != w[23];
  return status;
}

const char* ring_state_name(RingState state) {
  switch (state) {
    case RingState::kIdle:
      return "Idle";
    case RingState::kRunning:
      return "Run";
    case RingState::kHold:
      return "Hold";
    case RingState::kDone:
      return "Done";
    case RingState::kAlarm:
      return "Alarm";
    case RingState::kNoSession:
      return "No session";
  }
  return "unknown";
}

Result<std::array<std::uint16_t, kBlockWords>> encode_block(const NumericBlock& block, std::uint16_t seq,
                                                            const RingIdentity& scale, bool low_word_first) {
  constexpr double kMin = std::numeric_limits<std::int32_t>::min();
  constexpr double kMax = std::numeric_limits<std::int32_t>::max();
  constexpr double kMaxUnsigned = std::numeric_limits<std::uint32_t>::max();
  std::array<std::uint16_t, kBlockWords> words{};
  words[0] = seq;
  if ((block.kept != 0 || block.machine) && !scale.keeps)
    return fail(
        Code::kInput,
        "this controller takes moves of all five axes only, and '" + block.text +
            "' leaves some where they are; post with the profile's `retract: none` and begin with a G0 "
            "that states them all");
  words[1] =
      static_cast<std::uint16_t>(static_cast<unsigned>(block.op) | (block.inverse_time ? 0x0100U : 0U) |
                                 (static_cast<unsigned>(block.kept) << 9) | (block.machine ? 0x4000U : 0U));
  put_long(&words[2], static_cast<std::uint32_t>(block.line), low_word_first);
  const double linear = std::pow(10.0, scale.linear_exponent), rotary = std::pow(10.0, scale.rotary_exponent);
  const struct {
    const char* name;
    double value, scale;
  } axes[5] = {{"X", block.x, linear},
               {"Y", block.y, linear},
               {"Z", block.z, linear},
               {"A", block.tilt, rotary},
               {"C", block.rotary, rotary}};
  for (int axis = 0; axis < 5; ++axis) {
    const auto counts = scaled(axes[axis].name, axes[axis].value, axes[axis].scale, kMin, kMax);
    if (!counts) return tl::unexpected<Error>(counts.error());
    put_long(&words[4 + 2 * axis], *counts, low_word_first);
  }
  double feed = 0.0;
  if (block.op == BlockOp::kFeed) feed = block.feed;
  if (block.op == BlockOp::kDwell) feed = block.seconds;  // milliseconds
  if (block.op == BlockOp::kMCode) {
    feed = block.spindle;
    put_long(&words[4], static_cast<std::uint32_t>(block.m_code), low_word_first);
  }
  const auto counts = scaled("F", feed, kThousandths, 0.0, kMaxUnsigned);
  if (!counts) return tl::unexpected<Error>(counts.error());
  put_long(&words[14], *counts, low_word_first);
  return words;
}

std::vector<std::uint16_t> encode_window(std::uint16_t session,
                                         std::span<const std::array<std::uint16_t, kBlockWords>> blocks,
                                         bool end_of_program, bool low_word_first) {
  assert(!blocks.empty() && blocks.size() <= kWindowBlocks);
  std::vector<std::uint16_t> words(kWindowWords, 0);
  words[0] = session;
  words[1] = blocks[0][0];
  words[2] = static_cast<std::uint16_t>(blocks.size());
  words[3] = end_of_program ? 1 : 0;
  for (std::size_t k = 0; k < blocks.size(); ++k)
    for (std::size_t i = 0; i < kBlockWords; ++i) words[kFirstBlockWord + kBlockWords * k + i] = blocks[k][i];
  put_long(&words[kCrcWord], crc_without(words, kCrcWord), low_word_first);
  return words;
}

std::vector<std::uint16_t> encode_mailbox(std::uint16_t session, std::uint16_t command_seq, MailboxCode code,
                                          std::uint32_t argument, bool low_word_first) {
  std::vector<std::uint16_t> words(kMailboxWords, 0);
  words[0] = session;
  words[1] = command_seq;
  words[2] = static_cast<std::uint16_t>(code);
  put_long(&words[3], argument, low_word_first);
  put_long(&words[5], crc_without(words, 5), low_word_first);
  return words;
}

std::string pack_request(const ModbusRequest& request) {
  std::string bytes;
  bytes.reserve(8 + 2 * request.words.size());
  append_word(bytes, request.write_address);
  append_word(bytes, static_cast<std::uint16_t>(request.words.size()));
  append_word(bytes, request.read_address);
  append_word(bytes, request.read_count);
  for (const std::uint16_t word : request.words) append_word(bytes, word);
  return bytes;
}

ModbusRequest unpack_request(std::string_view bytes) {
  assert(bytes.size() >= 8 && bytes.size() == 8u + 2u * word_at(bytes, 1));
  ModbusRequest request{word_at(bytes, 0), word_at(bytes, 2), word_at(bytes, 3), {}};
  for (std::size_t i = 4; i < bytes.size() / 2; ++i) request.words.push_back(word_at(bytes, i));
  return request;
}

std::string pack_reply(const ModbusReply& reply) {
  std::string bytes(1, static_cast<char>(reply.outcome));
  for (const std::uint16_t word : reply.words) append_word(bytes, word);
  return bytes;
}

ModbusReply unpack_reply(std::string_view bytes) {
  assert(bytes.size() % 2 == 1);
  ModbusReply reply{static_cast<std::uint8_t>(bytes[0]), {}};
  for (std::size_t i = 0; i < bytes.size() / 2; ++i) reply.words.push_back(word_at(bytes.substr(1), i));
  return reply;
}

}  // namespace tiltfeed::daemon
