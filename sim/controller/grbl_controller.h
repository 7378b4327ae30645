#pragma once
// The firmware model of the Grbl family (character counting): bytes in, bytes out, simulated time, no I/O.
// The wire grammar and what each reply means are in sim/controller/README.md.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/controller/grbl_offsets.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/motion/motion.h"

namespace tiltfeed::sim {

// Error numbers of Grbl 1.1.
inline constexpr int kErrorNotIdle = 8, kErrorLocked = 9;

/// Defaults are those of grblHAL; Grbl 1.1h: rx_buffer 127, planner 15, max_line 79, both flags false.
struct GrblOptions {
  std::size_t rx_buffer = 1024;  ///< bytes that wait while the planner is full; more are lost
  std::size_t planner = 35;      ///< blocks
  std::size_t max_line = 256;    ///< bytes without the line end
  bool latch_errors = true;      ///< after an error every line is refused until an empty or `$` line
  bool crlf_is_one_end = true;   ///< CR LF earns one reply, not two
  MotionOptions motion{.feed_over_all_axes = true};
  std::optional<double> plate = {};  ///< machine Z of a probe's plate, as large as the table
  bool home_switches = true;         ///< false: homing finds none
};

struct GrblTotals {
  std::uint64_t dropped_bytes = 0;  ///< came while the receive buffer was full
  std::uint64_t lines = 0;          ///< answered with ok
  std::uint64_t errors = 0;         ///< answered with error:n
  std::uint64_t resets = 0;
};

/// Properties: one ok or error per line, in order; the ok of a line comes when its blocks are in the planner,
/// of G4 and M lines when they have been executed; real-time bytes act at once and take no buffer.
class GrblController {
 public:
  GrblController(const MachineModel& machine, const Setup& setup, const GrblOptions& options,
                 Motion::Sink sink);

  /// Bytes from the host arrive now.
  void receive(std::string_view bytes);
  /// Bytes for the host; empties the buffer.
  std::string take_output();
  /// A host has connected over a network: it gets the banner, and nothing is reset.
  void greet();
  bool has_output() const { return !out_.empty(); }

  /// Runs to `now`, s. Requires: now >= this->now().
  void advance(double now);
  /// When something will happen without a byte from the host; nothing when nothing will.
  std::optional<double> next_event() const { return motion_.next_event(); }
  double now() const { return motion_.now(); }

  int alarm() const { return alarm_; }  ///< 0: none
  /// The axes stop and everything queued is forgotten; needs a reset, then $X.
  void raise_alarm(int code);
  /// M2 or M30 was executed and nothing follows it.
  bool program_ended() const { return motion_.totals().programs > 0 && motion_.idle(); }
  const Motion& motion() const { return motion_; }
  /// It would take more lines at once.
  bool hungry() const { return !reply_due_; }
  const GrblTotals& totals() const { return totals_; }
  const GrblOffsets& offsets() const { return offsets_; }
  std::uint64_t dropped_bytes() const { return totals_.dropped_bytes; }

 private:
  bool realtime(unsigned char byte);
  void accept(char byte);
  void execute_line();
  void execute_gcode();
  void system_command(std::string_view command);
  void pump();
  bool place_pending();
  void reset();
  void reply_ok();
  void reply_error(int code);
  void feed_override(int percent);

  // What an operator asks for: grbl_operator.cpp.
  enum class Cycle : std::uint8_t { kNone, kJog, kCancel, kHome, kProbeWaits, kProbe };
  bool own_code();
  void select_system();
  int set_offsets(const GrblWords& words);
  int start_probe(const GrblWords& words);
  int start_jog(std::string_view words);
  int start_homing(std::string_view axis);
  std::optional<Joints> target_of(const GrblWords& words, bool relative, bool machine, const Joints& from);
  void begin_probe();
  void end_probe();
  bool follow_cycle();
  void cancel_jog();
  void soft_alarm(int code);
  void place_reader(const Joints& at);
  Joints planned_end() const;

  void report_status();
  void report_build();
  void report_parameters();
  void report_parser();
  std::string_view state() const;
  std::string accessories() const;

  GrblOptions options_;
  Motion motion_;
  GcodeReader reader_;
  GrblOffsets offsets_;
  GrblSettings settings_;
  Cycle cycle_ = Cycle::kNone;
  std::vector<Joints> home_way_;  ///< places that homing has yet to go to
  Block probe_;                   ///< the way to where the probe touches, or to its end
  GrblAxes touched_{};            ///< machine coordinates
  bool touches_ = false;          ///< the last probing did
  Joints jog_end_;                ///< of the newest jog
  std::string rx_;                ///< the receive buffer; bytes before rx_read_ are used up
  std::size_t rx_read_ = 0;
  std::string line_;  ///< the line being assembled
  bool line_too_long_ = false, after_cr_ = false;
  std::vector<Block> pending_;  ///< of the line whose reply is due
  std::size_t placed_ = 0;      ///< of pending_, in the planner or executed
  bool reply_due_ = false, waiting_ = false;
  int latched_error_ = 0, alarm_ = 0, spindle_override_ = 100;
  bool reset_needed_ = false, check_mode_ = false, report_overrides_ = true;
  int reports_to_offset_ = 0;  ///< status reports until the next WCO:
  int reports_to_overrides_ = 0;
  std::string reported_accessories_, out_;
  GrblTotals totals_;
};

}  // namespace tiltfeed::sim
