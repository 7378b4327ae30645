// What an operator asks a ring controller for, through the mailbox: each command has a number and is executed
// once, so it is repeated until the number comes back.

#include <algorithm>

#include "daemon/protocol/modbus_session.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

/// A mailbox command is a matter of one controller cycle; a controller that is slow, or a line that loses
/// some, takes longer. Both must be over: a slow line carries few replies in that time.
constexpr Time kObeyTime = std::chrono::seconds(5);
constexpr int kLeastTries = 20;

}  // namespace

void ModbusSession::command(const OperatorCommand& command, Time now) {
  const Answer answer = step_ >= Step::kPlace ? Answer::kIgnore : answer_to(command.order, phase_);
  refused_ = refusal_text(answer);
  // The controller still has blocks of the run that is gone on with: it is told, once it is known again.
  if (answer == Answer::kEnd && options_.attach) {
    ends_with_ = command.order;
    return;
  }
  if (answer == Answer::kEnd) {
    error_ = {Code::kCancelled, "stopped on request; nothing was sent"};
    return move(Event::kStood);
  }
  if (answer != Answer::kObey) return;
  switch (command.order) {
    case Order::kHold:
      note_hold(true, now);
      hold_seen_ = false;
      move(Event::kHeld);
      return post(MailboxCode::kHold, 0, now);
    case Order::kResume:
      return post(MailboxCode::kResume, 0, now);
    case Order::kStop:
      move(Event::kStopAsked);
      post(MailboxCode::kHold, 0, now);
      mail_.push_back({MailboxCode::kStop, 0});
      return mail_.push_back({MailboxCode::kClose, 0});
    case Order::kAbort:
      aborting_ = true;
      while (mail_.size() > 1) mail_.pop_back();  // the first one's number may be taken already
      return post(MailboxCode::kReset, 0, now);
    case Order::kFeedOverride:
      return post(MailboxCode::kOverride,
                  static_cast<std::uint32_t>(std::clamp(command.value, kMinOverride, kMaxOverride)), now);
    case Order::kRapidOverride:
    case Order::kSpindleOverride:
      refused_ = "this controller has a feed override only";
  }
}

/// A request that is out is given up for it: a frame may be repeated at any time. What waits already is not
/// asked for twice: on a poor line orders that pile up would keep every frame away.
void ModbusSession::post(MailboxCode code, std::uint32_t argument, Time now) {
  if (!mail_.empty() && mail_.back().code == code && mail_.back().argument == argument) return;
  if (mail_.size() > 1 && mail_.back().code == code) mail_.pop_back();  // another override
  if (mail_.empty()) mail_tries_ = 0, mail_since_ = now;
  mail_.push_back({code, argument});
  request_.clear();
  read_only_next_ = false;
  next_request_ = std::min(next_request_, now);
}

void ModbusSession::follow_mail(const RingStatus& status, Time now) {
  if (mail_.empty()) return;
  if (status.command_ack == command_seq_) {
    mail_.pop_front();
    ++command_seq_;
    mail_tries_ = 0;
    mail_since_ = now;
    if (status.command_result != 0) refused_ = "the controller refuses the command";
    return;
  }
  if (++mail_tries_ > kLeastTries && now - mail_since_ > kObeyTime)
    fault(Code::kLink, "the controller replies, but does not obey a command");
}

/// The ring was emptied and the session closed, so nobody can go on with it; what was read before stands.
void ModbusSession::finish_stop() {
  error_ = {Code::kCancelled, "stopped on request; " + describe(state()) +
                                  "; spindle and coolant may still be on: `tiltfeed reset` turns them off"};
  move(Event::kStood);
}

/// The map does not say why the controller holds; that its watchdog must have is known here.
void ModbusSession::note_hold(bool asked, Time now) {
  const Time silent = beats_ ? std::max(late_, now - last_heartbeat_) : Time::zero();
  if (asked)
    held_ = "held on request";
  else if (silent >= time_of(options_.map.watchdog))
    held_ = "held by the controller's own watchdog: no heartbeat from this host for " +
            decimal(std::chrono::duration<double>(silent).count(), 1) + " s; a resume goes on";
  else
    held_ = "held at the machine; a resume goes on";
}

void ModbusSession::follow_hold(const RingStatus& status, Time now) {
  const bool held = status.state == RingState::kHold;
  if (phase_ == Phase::kRun || phase_ == Phase::kDrain) {
    if (!held) late_ = Time::zero();
    if (!held) return;
    note_hold(false, now);
    hold_seen_ = true;
    // M0 counts as completed while it waits.
    const bool operator_stop = waits_at_ && waits_at_ == status.last_started;
    if (operator_stop) held_ = "waits for the operator (M0, M1, M6); a resume goes on";
    return move(operator_stop ? Event::kOperatorStop : Event::kHeld);
  }
  if (phase_ != Phase::kHold && phase_ != Phase::kToolChange) return;
  hold_seen_ = hold_seen_ || held;
  if (!hold_seen_ || held || !mail_.empty()) return;
  held_.clear();
  late_ = Time::zero();
  move(phase_ == Phase::kHold ? Event::kResumed : Event::kOperatorDone);
}

}  // namespace tiltfeed::daemon
