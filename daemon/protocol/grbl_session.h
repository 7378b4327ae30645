#pragma once
// The Grbl family's protocol: character counting against the controller's real receive buffer. Pure: no I/O
// and no clock, see daemon/protocol/session.h for the calls and daemon/protocol/README.md for the state
// diagram.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/program/line_reader.h"
#include "daemon/protocol/grbl_reply.h"
#include "daemon/protocol/planner_lines.h"
#include "daemon/protocol/position_watch.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

struct GrblOptions {
  std::uint64_t before = 0;        ///< lines that were sent before this session, and count as executed
  std::uint64_t total = 0;         ///< lines of the program
  std::size_t longest = 0;         ///< bytes of its longest line
  std::uint64_t longest_line = 0;  ///< that line's number
  int receive_buffer = 0;          ///< bytes; 0: ask
  int max_line = 0;                ///< bytes; 0: by the firmware's name
  bool check = false;              ///< read the whole program in check mode ($C) first
  bool number_lines = false;       ///< put N words in front, and take Ln: for what runs (grblHAL)
  PositionLimits positions = {};   ///< what reports of the axes are held to
};

/// Properties: the bytes of lines on their way (line + LF, from push to ok) never exceed window(); each "ok"
/// settles the oldest line; nothing but a whole "ok" settles anything; done only after the ok of a final
/// G4P0, and where places are reported only with the axes at the program's end; two reports in turn of a
/// place where no line in execution leads are a fault; real-time bytes overtake every line that the wire has
/// not taken yet.
class GrblSession {
 public:
  GrblSession(const GrblOptions& options, Time now);

  bool wants_work() const;
  /// Requires: wants_work().
  void push(Line line);
  void end_of_program() { ended_ = true; }
  /// True once: the check is over, the program is wanted again from its first line.
  bool wants_rewind();

  void command(const OperatorCommand& command, Time now);
  std::string_view output(Time now);
  void sent(std::size_t count);
  void receive(std::string_view bytes, Time now);
  Time deadline() const;
  /// The wire has gone: fault, with what may have run.
  void link_lost(const Error& error);

  Phase phase() const { return phase_; }
  SendState state() const;
  const Error& error() const { return error_; }
  /// Receive-buffer bytes that may be used; 0 until the controller has answered.
  std::size_t window() const { return window_; }
  std::size_t in_flight_bytes() const { return in_flight_bytes_; }

 private:
  /// Blocks that have left the planner but are still in the step segment buffer (10 segments on grblHAL).
  static constexpr std::size_t kStepSegments = 16;

  enum class Kind : std::uint8_t { kLine, kBarrier, kCheckOn, kCheckOff };
  struct Flight {
    Line line;
    std::uint64_t end = 0;  // bytes of output up to and with its LF, real-time bytes not counted
    Kind kind = Kind::kLine;
  };
  struct Override {
    int target = 0;    // percent; 0: never asked for
    int reported = 0;  // by the controller; 0: not yet
    Time stepped{};
  };

  void move(Event event);
  void on_line(std::string_view line);
  void write(std::string_view bytes);
  void urge(char byte);

  void on_opening_line(GrblReplyKind kind, std::string_view line);
  void start_probe();
  void end_probe();
  void begin_streaming();
  Result<void> check_buffers();
  void restart_after_check();
  void follow_check();
  void check_opening_time();
  bool ready() const;

  void move_next();
  bool put(Line line, Kind kind);
  void on_running_line(GrblReplyKind kind, std::string_view line);
  void on_status(std::string_view line);
  void on_ok();
  void follow_line_number();
  void check_running_time();
  bool waiting_for_operator() const;
  void settle(const Line& line);
  std::optional<AxisValues> place() const;
  double rounding() const;
  void take_offset();
  void follow_position();
  void prove_end();
  void narrow_range();
  std::size_t planner_depth() const;
  std::optional<bool> starved() const;
  bool reached_wire(const Flight& flight) const;
  LineRange uncertain() const;
  void fault(Code code, const std::string& what, bool hold, Event event = Event::kFailed);
  std::string refusal(const std::string& text) const;

  void end_opening(Order order);
  void ask_hold();
  void ask_stop();
  void ask_override(Override& which, int percent);
  void follow_hold();
  void follow_stop();
  void finish_stop();
  void urge_again(char byte);
  void follow_overrides();

  GrblOptions options_;
  Phase phase_ = Phase::kConnect;
  Error error_;
  Loss loss_ = Loss::kNone;
  std::string partial_;                    // bytes of a reply line that has not ended yet
  std::string out_;                        // bytes for the wire, real-time bytes first
  std::size_t urgent_ = 0;                 // of these, real-time bytes that no line waits for
  std::uint64_t written_ = 0, taken_ = 0;  // bytes of lines ever put into out_, and that the wire took
  std::size_t window_ = 0;
  Time now_{};

  // Opening.
  enum class Probe { kNone, kAsked, kAnswered } probe_ = Probe::kNone;
  bool identity_seen_ = false, probe_refused_ = false;
  std::optional<Time> plain_ok_;  // an ok before any [OPT:]: perhaps somebody else's
  GrblBuffers buffers_;
  int largest_receive_free_ = 0;
  bool long_lines_ = false;     // firmware with a 256-byte line buffer
  bool numbers_lines_ = false;  // firmware that reports Ln:
  std::string last_heard_;
  Time opened_{};
  bool checked_ = false, rewind_ = false;
  bool check_proved_ = false;  // a report has said that the controller is in check mode
  bool left_check_ = false;    // and then that it is not: lines may have run
  std::uint64_t first_checked_ = 0, last_checked_ = 0;  // lines that it has read

  // Streaming.
  std::optional<Line> next_;      // does not fit yet
  std::deque<Flight> in_flight_;  // oldest first
  std::size_t in_flight_bytes_ = 0;
  bool ended_ = false;
  std::uint64_t acknowledged_ = 0;
  PlannerLines recent_;  // the newest settled lines, which may not have run yet

  // Places.
  PositionWatch watch_;
  std::string axis_letters_;    // of [AXS:]
  std::vector<double> offset_;  // WCO:
  bool by_hand_ = false;        // the operator may move the axes
  int strange_ = 0;             // reports in turn of a place where the machine cannot be
  bool proving_ = false;        // the barrier is answered, the place is still out
  int proof_polls_ = 0;
  struct Stood {
    std::uint64_t executed = 0, sent = 0;
    LineRange lines;
  };
  std::optional<Stood> stood_;  // what is known of the range once the axes stand
  std::string stood_at_;        // the newest report of them, as text, and how many there were
  int stood_reports_ = 0;
  std::uint64_t line_named_ = 0;  // Ln: of the report before

  // Operator.
  bool hold_seen_ = false, reset_sent_ = false, held_on_request_ = false;
  Time asked_{}, repeated_{};
  Override feed_, rapid_, spindle_;
  std::string refused_;

  GrblStatus status_;
  bool status_seen_ = false;
  Time next_poll_{}, last_report_{}, last_progress_{};
};

}  // namespace tiltfeed::daemon
