// The steps before the stream: who answers, how it stands, a new session or one that goes on.

#include <algorithm>
#include <cmath>

#include "daemon/protocol/modbus_session.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

/// A mailbox command is a matter of one controller cycle.
constexpr Time kCommandTimeout = std::chrono::seconds(5);
/// A drive that follows late arrives within this many readings.
constexpr Time kPlacePoll = std::chrono::milliseconds(20);
constexpr int kMostPlacePolls = 25;
constexpr double kTurn = 360.0;

}  // namespace

void ModbusSession::on_identity(std::span<const std::uint16_t> words, Time now) {
  const Result<RingIdentity> identity = parse_identity(words);
  if (!identity) return fault(identity.error().code, identity.error().message);
  identity_ = *identity;
  if (options_.map.linear_exponent >= 0) identity_.linear_exponent = options_.map.linear_exponent;
  if (options_.map.rotary_exponent >= 0) identity_.rotary_exponent = options_.map.rotary_exponent;
  use_fc23_ = identity_.fc23;
  move(Event::kAnswered);
  step_ = Step::kLookAround;
  step_began_ = now;
}

void ModbusSession::look_around(const RingStatus& status, Time now) {
  status_ = status;
  command_seq_ = static_cast<std::uint16_t>(status.command_ack + 1);
  rereads_ = 0;
  if (status.state == RingState::kAlarm)
    return fault(Code::kLink,
                 "the machine is in alarm " + std::to_string(status.alarm) +
                     "; nothing was sent: end its cause, then `tiltfeed machine unlock`",
                 Event::kAlarm);
  if (options_.attach) return continue_run(status, now);
  if (status.state == RingState::kRunning || status.state == RingState::kHold)
    return fault(Code::kLink, std::string("the machine is in state ") + ring_state_name(status.state) +
                                  " with session " + std::to_string(status.session) +
                                  "; nothing was sent: `tiltfeed reset` ends that");
  step_ = Step::kOpen;
}

/// The controller's own counters say where the run stands; the caller's say which 65536 they belong to.
void ModbusSession::continue_run(const RingStatus& status, Time now) {
  if (identity_.boot_id != options_.boot)
    return lose(Loss::kRestarted, "the controller has restarted since (its start number, boot_id, was " +
                                      std::to_string(options_.boot) + " and is " +
                                      std::to_string(identity_.boot_id) +
                                      "): what was not completed is unknown; nothing more was sent");
  if (status.session != options_.session_id)
    return lose(Loss::kForgotten, "the controller has session " + std::to_string(status.session) + ", not " +
                                      std::to_string(options_.session_id) +
                                      ", any more; nothing more was sent");
  const int further = ring_ahead(status.last_accepted, ring_sequence(options_.accepted));
  const int open = ring_ahead(status.last_accepted, status.last_completed);
  known_ = options_.accepted + static_cast<std::uint64_t>(std::max(further, 0));
  if (further < 0 || open < 0 || known_ > options_.reserved || static_cast<std::uint64_t>(open) > known_)
    return fault(Code::kLink, "the controller's counters do not fit what is on record (accepted " +
                                  std::to_string(status.last_accepted) + ", on record " +
                                  std::to_string(options_.accepted) + " to " +
                                  std::to_string(options_.reserved) + "); nothing more was sent");
  completed_ = pushed_ = known_ - static_cast<std::uint64_t>(open);
  touched_ = known_;
  skip_ = completed_;
  step_ = Step::kStream;
  move(Event::kReady);
  last_progress_ = now;
  heartbeat_ = status.heartbeat;
  last_heartbeat_ = now - std::chrono::hours(1);  // due at once: a resume needs a living heartbeat
  read_only_next_ = true;  // the blocks that the controller has are read from the program first
  if (ends_with_) command({*ends_with_}, now);
}

void ModbusSession::on_command_status(const RingStatus& status, Time now) {
  const bool answered = status.command_ack == command_seq_;
  const bool late = now - step_began_ >= kCommandTimeout;
  status_ = status;
  if (!answered && !late) {
    next_request_ = now + kFullRingPoll;
    return;
  }
  if (step_ == Step::kClose) return move(Event::kProved);
  if (!answered) return fault(Code::kLink, "the controller does not answer to 'open session'");
  if (status.command_result != 0)
    return fault(Code::kLink, "the controller refuses a session (result " +
                                  std::to_string(status.command_result) + "); nothing was sent");
  if (status.session != options_.session_id || status.last_accepted != 0 || status.last_completed != 0)
    return fault(Code::kLink, "the controller opened another session than asked; nothing was sent");
  step_ = Step::kStream;
  ++command_seq_;
  move(Event::kReady);
  last_progress_ = now;
}

/// After the last block was read back as completed: the axes are where it leads, or it was not executed.
void ModbusSession::on_place(std::span<const std::uint16_t> words, Time now) {
  if (words.size() != kPositionsWords)
    return fault(Code::kLink, "a reading of the positions has the wrong length");
  const std::array<double, 5> at = parse_positions(words, identity_, options_.map.low_word_first);
  bool there = true;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!end_[i]) continue;
    const bool linear = i < 3;
    const double off = linear ? at[i] - *end_[i] : std::remainder(at[i] - *end_[i], kTurn);
    const double rounding = std::pow(10.0, -(linear ? identity_.linear_exponent : identity_.rotary_exponent));
    there = there && std::abs(off) <= (linear ? options_.tolerance.mm : options_.tolerance.deg) + rounding;
  }
  if (there) {
    step_ = Step::kClose;
    step_began_ = now;
    return;
  }
  next_request_ = now + kPlacePoll;
  if (++place_polls_ <= kMostPlacePolls) return;
  std::string reported, ends;
  for (std::size_t i = 0; i < at.size(); ++i) {
    reported += (i > 0 ? " " : "") + decimal(at[i], 3);
    ends += std::string(i > 0 ? " " : "") + (end_[i] ? decimal(*end_[i], 3) : "-");
  }
  elsewhere_ = true;
  fault(Code::kLink,
        "the axes (X Y Z tilt rotary) are at " + reported + " and not at the program's end, " + ends);
}

}  // namespace tiltfeed::daemon
