#pragma once
// The register map of the ring controller and the packing of requests for a message link.
// daemon/wire/MODBUS.md has the map with its rules. Registers are 16 bit; 32-bit values stand high word
// first; bytes high byte first.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/program/numeric_block.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

inline constexpr std::uint16_t kIdentityWords = 16, kWindowWords = 118, kMailboxWords = 7, kStatusWords = 24,
                               kPositionsWords = 10;
inline constexpr std::uint16_t kMagic = 0x5446, kMapVersion = 1;
inline constexpr std::uint16_t kBlockWords = 16, kWindowBlocks = 7;

enum class MailboxCode : std::uint16_t {
  kOpen = 1,
  kHold = 2,
  kResume = 3,
  kStop = 4,
  kReset = 5,
  kOverride = 6,
  kClearAlarm = 7,
  kClose = 8
};
enum class RingState : std::uint16_t {
  kIdle = 0,
  kRunning = 1,
  kHold = 2,
  kDone = 3,
  kAlarm = 4,
  kNoSession = 5
};
enum class Nack : std::uint16_t { kNone = 0, kGap = 1, kCrc = 2, kSession = 3, kBadBlock = 4 };

struct RingIdentity {
  bool fc23 = false;       ///< takes read/write in one request
  bool keeps = true;       ///< takes blocks that leave axes where they are, and machine coordinates
  bool positions = false;  ///< reports where the axes are
  int slots = 0;
  int linear_exponent = 4, rotary_exponent = 4;  ///< a position word counts 10^-exponent mm or degrees
  std::uint16_t boot_id = 0;
};
/// Errors: kLink when these words are not this map, with what is wrong.
Result<RingIdentity> parse_identity(std::span<const std::uint16_t> words);

struct RingStatus {
  std::uint16_t status_seq = 0, boot_id = 0, session = 0;
  std::uint16_t last_accepted = 0, last_started = 0, last_completed = 0, free_slots = 0;
  RingState state = RingState::kIdle;
  std::uint16_t alarm = 0;
  Nack nack = Nack::kNone;
  std::uint16_t nack_seq = 0, command_ack = 0, command_result = 0, feed_override = 0;
  std::uint16_t heartbeat = 0;  ///< as the controller heard it last
  std::uint32_t line = 0;
  bool torn = false;  ///< the first and the last word differ: read again
};
/// X Y Z tilt rotary, mm and degrees. Requires: kPositionsWords words.
std::array<double, 5> parse_positions(std::span<const std::uint16_t> words, const RingIdentity& scale,
                                      bool low_word_first);
/// Requires: kStatusWords words.
RingStatus parse_ring_status(std::span<const std::uint16_t> words, bool low_word_first);
const char* ring_state_name(RingState state);

/// One block as registers. Errors: kLimit when a value does not fit, with the axis and the value.
Result<std::array<std::uint16_t, kBlockWords>> encode_block(const NumericBlock& block, std::uint16_t seq,
                                                            const RingIdentity& scale, bool low_word_first);
/// The whole ring window. Requires: 1..kWindowBlocks blocks.
std::vector<std::uint16_t> encode_window(std::uint16_t session,
                                         std::span<const std::array<std::uint16_t, kBlockWords>> blocks,
                                         bool end_of_program, bool low_word_first);
std::vector<std::uint16_t> encode_mailbox(std::uint16_t session, std::uint16_t command_seq, MailboxCode code,
                                          std::uint32_t argument, bool low_word_first);

/// The number of a block in the ring; how far `to` is ahead of `from` when both count modulo 2^16.
inline std::uint16_t ring_sequence(std::uint64_t block) { return static_cast<std::uint16_t>(block); }
inline int ring_ahead(std::uint16_t to, std::uint16_t from) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(to - from));
}

/// A request on a message link: four header words (write address, write count, read address, read count),
/// then the words to write. Both counts above 0: one FC23; write only: FC16; read only: FC3.
struct ModbusRequest {
  std::uint16_t write_address = 0, read_address = 0, read_count = 0;
  std::vector<std::uint16_t> words;
};
std::string pack_request(const ModbusRequest& request);
/// Requires: `bytes` is what pack_request made.
ModbusRequest unpack_request(std::string_view bytes);

/// A reply on a message link: one byte of outcome, then the words that were read.
inline constexpr std::uint8_t kReplyOk = 0;          ///< 1..11 are the Modbus exceptions
inline constexpr std::uint8_t kReplyMissing = 0xFF;  ///< none came in time, or it was damaged
struct ModbusReply {
  std::uint8_t outcome = kReplyMissing;
  std::vector<std::uint16_t> words;
};
std::string pack_reply(const ModbusReply& reply);
ModbusReply unpack_reply(std::string_view bytes);

}  // namespace tiltfeed::daemon
