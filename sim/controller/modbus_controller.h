#pragma once
// The register-map model: a controller that takes numbered, CRC-protected windows of blocks through holding
// registers. Pure: register reads and writes in, simulated time. The map is in sim/controller/README.md.

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "sim/motion/motion.h"

namespace tiltfeed::sim {

// Areas of the map: first register and length, in words.
inline constexpr std::uint16_t kIdentityAt = 0x0000, kIdentityWords = 16;
inline constexpr std::uint16_t kWindowAt = 0x0100, kWindowWords = 118;
inline constexpr std::uint16_t kMailboxAt = 0x0180, kMailboxWords = 7;
inline constexpr std::uint16_t kStatusAt = 0x0200, kStatusWords = 24;
inline constexpr std::uint16_t kPositionsAt = 0x0220, kPositionsWords = 10;
inline constexpr std::uint16_t kHeartbeatAt = 0x0240;
inline constexpr std::uint16_t kMapEnd = 0x0241;

/// Words per mm and per degree. Dividing (not multiplying by 1e-4) gives the same double as reading the
/// decimal text.
inline constexpr double kPositionScale = 1e4;

inline constexpr std::uint16_t kMagic = 0x5446;
inline constexpr int kBlockWords = 16, kWindowHeaderWords = 6, kBlocksPerWindow = 7;

/// Exception codes of Modbus; kOk is none of them.
enum class Access : std::uint8_t { kOk = 0, kIllegalAddress = 2, kIllegalValue = 3 };

enum class RunState : std::uint16_t { kIdle, kRunning, kHold, kDone, kAlarm, kNoSession };
enum class Nack : std::uint16_t { kNone, kGap, kCrc, kSession, kBadBlock };
enum class Command : std::uint16_t {
  kOpen = 1,
  kHold,
  kResume,
  kStop,
  kReset,
  kOverride,
  kClearAlarm,
  kClose
};

struct ModbusOptions {
  std::size_t ring = 64;      ///< blocks
  std::uint16_t boot_id = 1;  ///< changes at every start
  double watchdog = 1.0;      ///< s of link time without a change of the heartbeat
  MotionOptions motion{};
};

/// CRC-32 (IEEE) over words, high byte first.
std::uint32_t crc_of_words(std::span<const std::uint16_t> words);

/// Properties: every accepted sequence number is executed exactly once, in order; a frame that is repeated
/// any number of times changes nothing; a frame that is refused changes nothing but the nack.
class ModbusController {
 public:
  ModbusController(const MachineModel& machine, const Setup& setup, const ModbusOptions& options,
                   Motion::Sink sink);
  ModbusController(const ModbusController&) = delete;
  ModbusController& operator=(const ModbusController&) = delete;

  Access write(std::uint16_t address, std::span<const std::uint16_t> words);
  /// A read of the status counts its status_seq up.
  Access read(std::uint16_t address, std::span<std::uint16_t> words);
  /// As after power-on: another boot id, no session; the positions stay.
  void reset();
  /// Is there something to read at all these registers? Changes nothing.
  static Access readable(std::uint16_t address, std::size_t count);

  /// Runs the machine to `now`, s. Requires: now >= this->now().
  void advance(double now) { motion_.advance(now); }
  /// Time on the link's side of the controller, s: only the watchdog looks at it. Never goes back.
  void advance_link(double link_now);
  /// When the machine will do something without a register access; nothing when it will not.
  std::optional<double> next_event() const { return motion_.next_event(); }
  double now() const { return motion_.now(); }

  const Motion& motion() const { return motion_; }
  /// There is room for a whole window (half a small ring), which a host waits for before it sends.
  bool has_room() const {
    return motion_.free_slots() >= std::clamp<std::size_t>(motion_.slots() / 2, 1, kBlocksPerWindow);
  }
  /// It would take more, and the program goes on.
  bool hungry() const { return has_room() && !end_seq_; }
  RunState state() const;
  /// A program came to its end (M2, M30 or the end flag) and nothing follows it.
  bool program_ended() const { return motion_.idle() && (programs_ > 0 || motion_.totals().programs > 0); }
  std::uint64_t rejected_windows() const { return rejected_; }

 private:
  using Words = std::span<const std::uint16_t>;

  void take_window(Words words);
  void take_mailbox(Words words);
  bool execute(Command command, std::uint16_t session, std::uint32_t argument);
  bool open(std::uint16_t session);
  void take_heartbeat(std::uint16_t value);
  void note_end();
  void refuse(Nack nack, std::uint16_t seq);
  /// Link time at which the watchdog will hold a running machine; nothing while it is not armed.
  std::optional<double> watchdog_at() const;
  bool append(Words block);
  std::optional<Block> decode(Words block) const;
  void forget_blocks();
  void executed(const TraceRow& row);
  std::array<std::uint16_t, kStatusWords> status() const;
  std::array<std::uint16_t, kIdentityWords> identity() const;
  std::array<std::uint16_t, kPositionsWords> positions() const;

  ModbusOptions options_;
  Motion::Sink sink_;
  Motion motion_;
  std::deque<std::uint16_t> seqs_;  ///< of the blocks in motion_, in step with its queue
  Joints planned_;                  ///< where the last accepted motion block ends
  std::uint16_t boot_id_, session_ = 0;
  std::uint16_t last_accepted_ = 0, last_started_ = 0, last_completed_ = 0;
  std::optional<std::uint16_t> end_seq_;  ///< the program's last block, once it was announced
  Nack nack_ = Nack::kNone;
  std::uint16_t nack_seq_ = 0, cmd_ack_ = 0, cmd_result_ = 0, alarm_ = 0, status_seq_ = 0, heartbeat_ = 0;
  bool heartbeat_seen_ = false, done_ = false;
  bool spent_ = false;  ///< blocks of this session were dropped: it takes no others
  double link_now_ = 0.0, heartbeat_at_ = 0.0;
  std::uint64_t rejected_ = 0, programs_ = 0;
};

}  // namespace tiltfeed::sim
