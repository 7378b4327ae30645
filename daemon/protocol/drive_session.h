#pragma once
// A plain Modbus drive: one block at a time, written with its trigger last, then its status is asked until it
// stands. Nothing in the drive tells one write from the same write repeated, so none is ever repeated. Pure:
// no I/O and no clock, see daemon/protocol/session.h for the calls and daemon/protocol/README.md for the
// rules.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/protocol/drive_block.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/link.h"
#include "daemon/wire/modbus_map.h"

namespace tiltfeed::daemon {

struct DriveOptions {
  std::uint64_t total = 0;  ///< blocks of the program
  config::DriveMap map = {};
};

/// Properties: a move is written once, unless an operator resumes a hold that cut it short; when no answer to
/// it comes the run is a fault, the drive is told to stop, and nothing else is sent; the next block leaves
/// only after the drive has said that it stands. What repeats by itself: reading, and the stop value.
class DriveSession {
 public:
  DriveSession(const DriveOptions& options, Time now);

  bool wants_work() const;
  /// Requires: wants_work().
  void push(NumericBlock block);
  void pass(const NumericBlock&) {}
  void end_of_program() { ended_ = true; }
  bool wants_rewind() const { return false; }
  std::optional<std::uint64_t> first_block() const { return 0; }

  void command(const OperatorCommand& command, Time now);
  std::string_view output(Time now);
  void sent(std::size_t count);
  void receive(std::string_view reply, Time now);
  Time deadline() const { return next_; }
  void link_lost(const Error& error);

  Phase phase() const { return phase_; }
  SendState state() const;
  const Error& error() const { return error_; }

 private:
  /// What is asked next, or waited for.
  enum class Step : std::uint8_t { kLook, kChoose, kWrite, kWatch, kDwell, kOperator, kStop, kStand, kHeld };
  struct Pending {
    NumericBlock block;
    std::vector<std::uint16_t> words;  // none: it moves nothing
  };

  void move(Event event);
  void choose(Time now);
  void complete();
  void on_status(std::uint16_t status, Time now);
  void on_missing(Time now);
  void go_on();
  void ask_stop(Event event, Time now);
  void fault(const std::string& what, Event event = Event::kFailed);
  std::string stop_request() const;
  std::string range_text() const;
  LineRange uncertain() const;

  DriveOptions options_;
  DriveEncoder encoder_;
  Phase phase_ = Phase::kConnect;
  Step step_ = Step::kLook;
  Error error_;
  Loss loss_ = Loss::kNone;
  std::deque<Pending> pending_;  // the front one is in work
  std::uint64_t completed_ = 0;
  bool ended_ = false;
  bool resume_asked_ = false;                // before the drive stands
  bool written_ = false, answered_ = false;  // the front one left; the drive took it
  std::string request_, refused_;
  Time next_{}, heard_{}, stop_asked_{};
};

}  // namespace tiltfeed::daemon
