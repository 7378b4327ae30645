#pragma once
// A CNC control that is fed over its serial port while it cuts: DC1 and DC3, a small buffer, %. Bytes in,
// bytes out, simulated time, no I/O. The wire is described in sim/controller/README.md.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/gcode/gcode_reader.h"
#include "sim/motion/motion.h"

namespace tiltfeed::sim {

struct DripControlOptions {
  std::size_t buffer = 512;    ///< bytes
  std::size_t stop_free = 64;  ///< DC3 when so few bytes are free
  std::size_t go_free = 256;   ///< DC1 when so many are free again
  std::size_t planner = 16;    ///< blocks
  double start_at = 0.0;       ///< s: the operator presses start, the control sends DC1
  bool says_xon_xoff = true;   ///< otherwise clear_to_send() is the only sign
};

/// Alarm numbers of Fanuc.
inline constexpr int kAlarmFraming = 85, kAlarmBufferOverflow = 87;

class DripController {
 public:
  DripController(const MachineModel& machine, const Setup& setup, const DripControlOptions& options,
                 Motion::Sink sink);

  void receive(std::string_view bytes);
  std::string take_output();
  bool has_output() const { return !out_.empty(); }
  /// Runs to `now`, s. Requires: now >= this->now().
  void advance(double now);
  std::optional<double> next_event() const;
  double now() const { return motion_.now(); }

  /// DC1 once more, while nothing has come: for a host that was not there the first time.
  void invite();
  bool clear_to_send() const { return started_ && !stopped_; }
  int alarm() const { return alarm_; }  ///< 0: none
  /// Raises an alarm (NAK), or is reset by the operator (SYN).
  void raise_alarm(int code);
  void reset();
  bool program_ended() const { return ended_ && motion_.idle(); }
  const Motion& motion() const { return motion_; }
  /// It would take more lines at once.
  bool hungry() const { return !ended_ && clear_to_send(); }
  /// Most bytes that came between a DC3 and its DC1.
  std::size_t most_after_stop() const { return most_after_stop_; }
  std::uint64_t bytes_before_start() const { return before_start_; }
  std::uint64_t leader() const { return leader_; }

 private:
  void pump();
  bool take_block(std::string_view text);

  DripControlOptions options_;
  Motion motion_;
  GcodeReader reader_;
  std::string buffer_, out_;
  std::vector<Block> pending_;
  std::size_t placed_ = 0, after_stop_ = 0, most_after_stop_ = 0;
  bool started_ = false, stopped_ = false, in_program_ = false, ended_ = false, waiting_ = false;
  int alarm_ = 0;
  std::uint64_t before_start_ = 0, leader_ = 0;
};

}  // namespace tiltfeed::sim
