#pragma once
// A wire that follows a fault script: bytes and frames go in, what is left of them comes out. Pure: link time
// is given, chance is seeded.

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <string>
#include <string_view>

#include "sim/wire/fault_script.h"

namespace tiltfeed::sim {

/// What becomes of one Modbus frame.
struct FrameFate {
  bool lose_request = false, lose_reply = false, wrong_unit = false, half_frame = false;
  double late = 0.0;  ///< s
  int exception = 0;
};

class FaultyLine {
 public:
  explicit FaultyLine(const FaultScript& script);

  /// Bytes from the host enter the wire at `now`.
  void to_machine(std::string_view bytes, double now);
  void to_host(std::string_view bytes, double now);
  /// A whole Modbus frame, of which only bytes go wrong here; frame() is asked for the rest.
  void frame_to_host(std::string_view bytes, double now);
  /// What has come through by `now`.
  std::string at_machine(double now);
  std::string at_host(double now);
  /// The fate of the frame that comes now. Counts each fault.
  FrameFate frame();

  /// Rules of the controller and of the whole link that are due: performed once each.
  bool reset_due(double now) { return due(FaultKind::kReset, now); }
  bool alarm_due(double now) { return due(FaultKind::kAlarm, now); }
  /// The device is away at `now` (disconnect), or dumb (silence).
  bool away(double now);
  bool silent(double now);
  bool slow_read() const { return slow_read_; }

  std::uint64_t faults() const { return faults_; }
  std::uint64_t faults(FaultKind kind) const { return counts_[static_cast<std::size_t>(kind)]; }

 private:
  struct Passing {
    double at = 0.0;
    std::string bytes;
  };
  struct Way {
    std::deque<Passing> queue;
    double not_before = 0.0;
    std::string line;          ///< reply bytes of a line that has not ended (to the host only)
    std::uint64_t clean = 0;   ///< bytes until the next fault of one byte
    double probability = 0.0;  ///< that a byte is faulty
  };

  bool chance(double probability);
  bool due(FaultKind kind, double now);
  bool happens(FaultKind kind, Side side);
  std::uint64_t clean_run(Side side);
  FaultKind byte_fault(Side side);
  const FaultRule* rule(FaultKind kind) const;
  void note(FaultKind kind);
  void spoil(std::string_view bytes, Side side, double now, Way& way);
  void spoil_reply(std::string_view line, double now);
  static std::string take(Way& way, double now);

  FaultScript script_;
  std::mt19937_64 random_;
  std::vector<bool> done_;  ///< of the timed rules
  Way machine_, host_;
  double away_until_ = -1.0, silent_until_ = -1.0;
  bool slow_read_ = false;
  std::uint64_t faults_ = 0;
  std::array<std::uint64_t, 32> counts_{};
};

}  // namespace tiltfeed::sim
