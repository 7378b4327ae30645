#pragma once
// The firmware model of a RepRap machine (Marlin): numbered lines with a checksum, a queue of commands,
// resend. Bytes in, bytes out, simulated time, no I/O. The wire grammar is in sim/controller/README.md.

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/gcode/gcode_reader.h"
#include "sim/motion/motion.h"

namespace tiltfeed::sim {

struct RepRapOptions {
  std::size_t rx_buffer = 128;   ///< bytes; more are lost
  std::size_t max_line = 95;     ///< bytes
  std::size_t queue = 4;         ///< commands
  std::size_t planner = 16;      ///< blocks
  bool resend_ok = true;         ///< an ok follows each resend
  bool advanced_ok = false;      ///< "ok N5 P15 B3"
  bool emergency_parser = true;  ///< M108, M112 and M410 act at once
  bool work_systems = true;      ///< G54 to G59.3
};

struct RepRapTotals {
  std::uint64_t dropped_bytes = 0, lines = 0, resends = 0, resets = 0;
};

/// Properties: a line is executed once, in the order of its number; ok when a command has left the queue (its
/// blocks are in the planner; M400 and G4: executed); a line that is damaged, or has another number than the
/// next, is refused with a resend and the receive buffer is flushed.
class RepRapController {
 public:
  RepRapController(const MachineModel& machine, const Setup& setup, const RepRapOptions& options,
                   Motion::Sink sink);

  void receive(std::string_view bytes);
  std::string take_output();
  bool has_output() const { return !out_.empty(); }
  /// Runs to `now`, s. Requires: now >= this->now().
  void advance(double now);
  std::optional<double> next_event() const;
  double now() const { return motion_.now(); }

  /// Loses everything but the position, as after the reset button.
  void reset();
  /// Stands still for good, as after a thermal runaway.
  void halt();
  /// Refuses to move until M999, as after an error that it survives.
  void stop_after_error() { stopped_ = true; }
  bool program_ended() const { return motion_.totals().programs > 0 && motion_.idle(); }
  const Motion& motion() const { return motion_; }
  /// It would take more lines at once.
  bool hungry() const { return queue_.empty() && placed_ >= pending_.size() && !paused_ && !halted_; }
  const RepRapTotals& totals() const { return totals_; }

 private:
  struct Command {
    std::string text;
    std::uint64_t number = 0;
  };

  void read_lines();
  void take_line(std::string text);
  void refuse(const std::string& what);
  bool emergency(std::string_view line);
  void pump();
  bool run(const Command& command);
  bool place();
  bool run_own(const std::string& text);
  void home(const std::string& text);
  void place_reader(const Joints& stands);
  void set_offset(const std::string& text);
  void report_settings();
  Joints shifted(const Joints& at, double sign) const;
  void report_place();
  void reply_ok(const Command& command);

  RepRapOptions options_;
  Motion motion_;
  GcodeReader reader_;
  std::string rx_, line_,
      live_;  ///< waiting bytes, the line being assembled, the same for the emergency parser
  std::deque<Command> queue_;
  std::vector<Block> pending_;
  std::size_t placed_ = 0;
  std::array<Joints, 10> offsets_{};  ///< of G54 to G59.3, and of none; program 0 on the simulated axes
  std::size_t system_ = 9;
  std::map<std::string, std::string> settings_{
      {"M201", "X500.00 Y500.00"}, {"M203", "X500.00 Y500.00 Z50.00"}, {"M92", "X80.00 Y80.00 Z400.00"}};
  bool stopped_ = false;
  bool started_ = false, waiting_ = false, paused_ = false, halted_ = false;
  std::uint64_t last_number_ = 0;
  double busy_at_ = 0.0;  ///< when the next "busy" is due while a command waits
  std::string out_;
  RepRapTotals totals_;
};

}  // namespace tiltfeed::sim
