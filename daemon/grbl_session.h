#pragma once
// The Grbl family's protocol: character counting against the controller's real receive buffer. Pure: no I/O
// and no clock, see daemon/session.h for the calls and daemon/README.md for the state diagram.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/grbl_reply.h"
#include "daemon/link.h"
#include "daemon/program.h"
#include "daemon/session.h"

namespace tiltfeed {

struct GrblOptions {
  std::uint64_t total = 0;         ///< lines of the program
  std::size_t longest = 0;         ///< bytes of its longest line
  std::uint64_t longest_line = 0;  ///< that line's number
  int receive_buffer = 0;          ///< bytes; 0: ask
  int max_line = 0;                ///< bytes; 0: by the firmware's name
};

/// Properties: the bytes of lines on their way (line + LF, from push to ok) never exceed window(); each "ok"
/// settles the oldest line; nothing but a whole "ok" settles anything; done only after the ok of a final
/// G4P0.
class GrblSession {
 public:
  GrblSession(const GrblOptions& options, Time now);

  bool wants_work() const;
  /// Requires: wants_work().
  void push(Line line);
  void end_of_program() { ended_ = true; }

  std::string_view output(Time now);
  void sent(std::size_t count);
  void receive(std::string_view bytes, Time now);
  Time deadline() const;
  /// Feed hold, then fault.
  void stop();
  /// The wire has gone: fault, with what may have run.
  void link_lost(const Error& error);

  Phase phase() const { return phase_; }
  SendState state() const;
  const Error& error() const { return error_; }
  /// Receive-buffer bytes that may be used; 0 until the controller has answered.
  std::size_t window() const { return window_; }
  std::size_t in_flight_bytes() const { return in_flight_bytes_; }

 private:
  struct Flight {
    Line line;
    std::uint64_t end = 0;  // bytes of output up to and with its LF
    bool barrier = false;   // the final G4P0
  };

  void on_line(std::string_view line);
  void on_opening_line(GrblReplyKind kind, std::string_view line);
  void on_running_line(GrblReplyKind kind, std::string_view line);
  void on_status(std::string_view line);
  void on_ok();
  void write(std::string_view bytes);
  void start_probe();
  void end_probe();
  void begin_streaming();
  void move_next();
  void check_opening_time();
  void check_running_time();
  bool ready() const;
  bool waiting_for_operator() const;
  std::size_t planner_depth() const;
  bool reached_wire(const Flight& flight) const;
  std::string uncertain_lines() const;
  void fault(Code code, const std::string& what, bool hold);

  GrblOptions options_;
  Phase phase_ = Phase::kOpening;
  Error error_;
  std::string partial_;                    // bytes of a reply line that has not ended yet
  std::string out_;                        // bytes for the wire
  std::uint64_t written_ = 0, taken_ = 0;  // bytes ever put into out_, bytes that the wire took
  std::size_t window_ = 0;
  Time now_{};

  // Opening.
  enum class Probe { kNone, kAsked, kAnswered } probe_ = Probe::kNone;
  bool identity_seen_ = false, probe_refused_ = false;
  std::optional<Time> plain_ok_;  // an ok before any [OPT:]: perhaps somebody else's
  GrblBuffers buffers_;
  int largest_receive_free_ = 0;
  bool long_lines_ = false;  // firmware with a 256-byte line buffer
  std::string last_heard_;
  Time opened_{};

  // Streaming.
  std::optional<Line> next_;      // does not fit yet
  std::deque<Flight> in_flight_;  // oldest first
  std::size_t in_flight_bytes_ = 0;
  bool ended_ = false;
  std::uint64_t acknowledged_ = 0;
  std::deque<std::uint64_t> recent_;  // numbers of the newest settled lines, which may not have run yet

  GrblStatus status_;
  bool status_seen_ = false;
  Time next_poll_{}, last_report_{}, last_progress_{};
};

}  // namespace tiltfeed
