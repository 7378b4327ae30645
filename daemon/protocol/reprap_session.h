#pragma once
// RepRap firmwares (Marlin): numbered lines with a checksum, resend, a window. Pure: no I/O and no clock, see
// daemon/protocol/session.h for the calls and daemon/protocol/README.md for the rules.

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "daemon/program/line_reader.h"
#include "daemon/protocol/planner_lines.h"
#include "daemon/protocol/position_watch.h"
#include "daemon/protocol/reprap_reply.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

struct RepRapOptions {
  std::uint64_t total = 0;        ///< lines of the program
  int window = 0;                 ///< unanswered lines; 0: what its "ok ... B" figures allow, else 1
  PositionLimits positions = {};  ///< what the place at the end is held to
  std::uint64_t before = 0;       ///< lines that were sent before this session, and count as executed
};

/// Properties: everything in the stream has a number and a checksum; a number is sent again only as it was;
/// never more lines unanswered than the window; done only after the ok of a final M400, and where M114 tells
/// a place, at the program's end. The checksum is an XOR of eight bits: damage that keeps it is not seen.
class RepRapSession {
 public:
  RepRapSession(const RepRapOptions& options, Time now);

  bool wants_work() const;
  /// Requires: wants_work().
  void push(Line line);
  void end_of_program() { ended_ = true; }
  bool wants_rewind() const { return false; }

  void command(const OperatorCommand& command, Time now);
  std::string_view output(Time now);
  void sent(std::size_t count);
  void receive(std::string_view bytes, Time now);
  Time deadline() const { return deadline_; }
  void link_lost(const Error& error);

  Phase phase() const { return phase_; }
  SendState state() const;
  const Error& error() const { return error_; }
  std::size_t window() const { return window_; }

 private:
  enum class Kind : std::uint8_t { kLine, kProbe, kInserted, kBarrier, kPlace };
  struct Numbered {
    std::uint64_t number = 0;  // N word
    Line line;
    Kind kind = Kind::kLine;
  };

  void move(Event event);
  void append(Line line, Kind kind);
  void write_due();
  void on_line(std::string_view line);
  void on_opening(const RepRapReply& reply, std::string_view line);
  void on_ok(const RepRapReply& reply);
  void on_resend(const RepRapReply& reply);
  void settle_before(std::uint64_t number);
  void settle_front();
  bool take_back(std::uint64_t number);
  void check_time();
  void ask_place();
  void take_place(std::string_view line);
  void prove_end();
  LineRange uncertain() const;
  void fault(Code code, const std::string& what);
  void ask_stop();

  RepRapOptions options_;
  Phase phase_ = Phase::kConnect;
  Error error_;
  Loss loss_ = Loss::kNone;
  std::string partial_, out_;
  std::size_t window_ = 1;
  Time now_{}, opened_{}, asked_{}, last_heard_{}, deadline_{};
  bool ended_ = false, emergency_ = false, numbers_known_ = false;
  std::string firmware_, last_text_;

  std::uint64_t next_number_ = 1;           // of the next line that is appended
  std::uint64_t due_ = 1;                   // the next number to write
  std::deque<Numbered> history_;            // from the oldest that is not settled
  std::deque<Numbered> settled_;            // before these, in case an ok was taken for another
  std::uint64_t owed_ = 0;                  // oks still to come for lines that a resend has settled
  bool resend_ok_due_ = false;              // the ok right after a refusal belongs to it
  std::optional<std::uint64_t> last_line_;  // of the error before a resend
  std::uint64_t resends_ = 0, repeated_number_ = 0;
  int repeats_ = 0, probes_ = 0;
  Time quiet_until_{};         // nothing is sent before
  bool rounds_begun_ = false;  // something was sent since the last resend
  bool probing_ = false;       // after a silence: no ok is on its way any more
  std::uint64_t acknowledged_ = 0, touched_ = 0;
  PlannerLines recent_;         // answered, and perhaps not run yet
  bool quick_stopped_ = false;  // what was planned is dropped: it has not run, whatever is answered
  std::string machine_, refused_;

  PositionWatch watch_;
  std::optional<AxisValues> place_;  // of the newest M114
  int places_ = 0;                   // that were not the program's end
};

/// "N12G1X3*85": the line with its number and checksum.
std::string reprap_frame(std::uint64_t number, std::string_view text);

}  // namespace tiltfeed::daemon
