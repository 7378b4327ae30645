#pragma once
// DNC drip feed: the program as plain text to a CNC control that says stop and go (DC3 and DC1, or its CTS
// line). Nothing comes back that proves anything. Pure: no I/O and no clock, see daemon/protocol/session.h
// for the calls.

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "config/link_profile.h"
#include "daemon/program/line_reader.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

struct DripOptions {
  std::uint64_t total = 0;  ///< lines of the program
  int baud = 9600;
  config::DripFormat format = {};
};

/// Properties: the bytes are leader, %, the lines in order, %, trailer; nothing before the first DC1 if the
/// format wants one; between DC3 and DC1 nothing is given to the wire, and what was given before takes at
/// most kDripAhead on the line; done when the last byte has left, which proves nothing about the machine.
class DripSession {
 public:
  DripSession(const DripOptions& options, Time now);

  bool wants_work() const;
  /// Requires: wants_work().
  void push(Line line);
  void end_of_program();
  bool wants_rewind() const { return false; }

  void command(const OperatorCommand& command, Time now);
  std::string_view output(Time now);
  void sent(std::size_t count);
  void receive(std::string_view bytes, Time now);
  Time deadline() const;
  void link_lost(const Error& error);

  Phase phase() const { return phase_; }
  SendState state() const;
  const Error& error() const { return error_; }

 private:
  struct Open {
    std::uint64_t line = 0, end = 0;  // number in the file, bytes up to and with its end of block
  };

  void move(Event event);
  void fault(const std::string& what);
  void start();
  /// Whether a part of the next line has left.
  bool begun() const { return !open_.empty() && taken_ > whole_; }
  LineRange uncertain() const;

  DripOptions options_;
  Phase phase_ = Phase::kConnect;
  Error error_;
  Loss loss_ = Loss::kNone;
  std::string out_;                        // not yet given to the wire
  std::uint64_t written_ = 0, taken_ = 0;  // bytes ever put into out_, and that the wire took
  std::uint64_t whole_ = 0;                // of these, up to the end of the newest line that left whole
  std::size_t shown_ = 0;                  // bytes of out_ that output() has shown
  std::deque<Open> open_;                  // lines that are not whole on the wire
  std::uint64_t lines_ = 0, first_line_ = 0, last_line_ = 0;
  Time byte_time_{}, free_at_{}, now_{};  // when the wire will have sent what it took
  bool stopped_by_control_ = false, ended_ = false;
  std::string refused_;
};

/// How long the wire may be busy with what it was given: so much follows a DC3, plus one FIFO of the adapter.
inline constexpr Time kDripAhead = std::chrono::milliseconds(10);

}  // namespace tiltfeed::daemon
