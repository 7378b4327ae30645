// What an operator asks a Grbl session for: feed hold, resume, stop, abort, overrides. Real-time bytes may be
// lost like any other, so each is repeated until the status shows that it has acted.

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "daemon/protocol/grbl_session.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr char kHoldByte = '!', kResumeByte = '~', kResetByte = 0x18;
/// A status interval: what was asked for must show in the next report.
constexpr Time kRepeatInterval = milliseconds(200);
/// The first look at whether a hold has acted.
constexpr Time kHoldLook = milliseconds(20);
/// From feed hold to standstill: longer than any axis needs to brake.
constexpr Time kStandTimeout = seconds(10);
/// Reports of a standing machine that are read until two in turn agree.
constexpr int kMostStoodReports = 4;
/// Override steps that are on their way are not sent again before they must have been reported.
constexpr Time kOverrideSettle = milliseconds(600);

struct OverrideBytes {
  unsigned char up10, down10, up1, down1;
};
constexpr OverrideBytes kFeedBytes{0x91, 0x92, 0x93, 0x94}, kSpindleBytes{0x9A, 0x9B, 0x9C, 0x9D};
constexpr unsigned char kRapidFull = 0x95, kRapidHalf = 0x96, kRapidQuarter = 0x97;

}  // namespace

void GrblSession::command(const OperatorCommand& command, Time now) {
  now_ = now;
  const Answer answer = answer_to(command.order, phase_);
  refused_ = refusal_text(answer);
  if (answer == Answer::kEnd) return end_opening(command.order);
  if (answer != Answer::kObey) return;
  switch (command.order) {
    case Order::kHold:
      return ask_hold();
    case Order::kResume:
      urge(kResumeByte);
      last_progress_ = now_;
      if (phase_ == Phase::kHold) hold_seen_ = true;  // the next report that shows no hold ends it
      return;
    case Order::kStop:
      return ask_stop();
    case Order::kAbort:
      loss_ = Loss::kRestarted;
      fault(Code::kCancelled, "aborted on request: the controller was reset in motion, home it first", false);
      out_ = kResetByte;
      return;
    case Order::kFeedOverride:
      return ask_override(feed_, std::clamp(command.value, kMinOverride, kMaxOverride));
    case Order::kRapidOverride:
      return ask_override(rapid_, command.value >= 100 ? 100 : command.value >= 50 ? 50 : 25);
    case Order::kSpindleOverride:
      return ask_override(spindle_, std::clamp(command.value, kMinOverride, kMaxOverride));
  }
}

/// A reset leaves check mode, and stops what somebody else may have set in motion.
void GrblSession::end_opening(Order order) {
  const bool reset = phase_ == Phase::kCheck || order == Order::kAbort;
  error_ = {Code::kCancelled, "stopped on request; nothing has moved"};
  move(Event::kStood);
  out_ = reset ? std::string(1, kResetByte) : std::string();
  urgent_ = out_.size();
}

void GrblSession::ask_hold() {
  urge(kHoldByte);
  repeated_ = now_;
  hold_seen_ = false;
  held_on_request_ = true;
  next_poll_ = std::min(next_poll_, now_ + kHoldLook);
  move(Event::kHeld);
}

/// Once a status interval, until a report shows that it has acted.
void GrblSession::urge_again(char byte) {
  if (now_ - repeated_ < kRepeatInterval) return;
  urge(byte);
  repeated_ = now_;
}

void GrblSession::ask_stop() {
  out_.clear();
  urgent_ = 0;
  urge(kHoldByte);
  asked_ = repeated_ = now_;
  reset_sent_ = false;
  move(Event::kStopAsked);
}

/// After each report while kHold: is it there, is it over?
void GrblSession::follow_hold() {
  const bool held = status_.state.starts_with("Hold") || status_.state.starts_with("Door");
  if (phase_ == Phase::kRun || phase_ == Phase::kDrain) {
    if (!held) return;
    hold_seen_ = true;
    held_on_request_ = false;
    return move(Event::kHeld);
  }
  if (phase_ != Phase::kHold) return;
  if (held) {
    hold_seen_ = true;
  } else if (hold_seen_) {
    move(Event::kResumed);
    last_progress_ = now_;
    if (!in_flight_.empty() && in_flight_.back().kind == Kind::kBarrier) move(Event::kAllSent);
  } else {
    urge_again(kHoldByte);
  }
}

/// After each report while kStop. A reset of a machine that stands keeps its position.
void GrblSession::follow_stop() {
  const std::string& state = status_.state;
  // After the reset the banner ends it: a report may be from before, even if it comes later.
  if (!reset_sent_ && is_standing(state) && now_ - asked_ >= kRepeatInterval) {
    // The first report may be from before the hold; one interval later it is not. None has a checksum, so the
    // place counts when two in turn say the same.
    if (state == "Hold:0") {
      const std::string said = status_.position + " " + std::to_string(status_.line);
      const bool agree = std::exchange(stood_at_, said) == said;
      if (!agree && ++stood_reports_ < kMostStoodReports) {
        next_poll_ = now_;
        return;
      }
      if (agree) narrow_range();
    }
    urge(kResetByte);
    reset_sent_ = true;
    return;
  }
  if (now_ - asked_ >= kStandTimeout)
    return fault(Code::kLink,
                 reset_sent_ ? "the controller has not answered the reset that ends the stop"
                             : "the machine does not stand 10 s after the stop",
                 true);
  urge_again(reset_sent_ ? kResetByte : kHoldByte);
}

void GrblSession::finish_stop() {
  error_ = {Code::kCancelled, "stopped on request; " + describe(this->state())};
  move(Event::kStood);
  out_.clear();
  urgent_ = 0;
}

void GrblSession::ask_override(Override& which, int percent) {
  which.target = percent;
  which.stepped = Time{};
  follow_overrides();
}

/// Steps from what the controller reports to what was asked for, and again if a step was lost.
void GrblSession::follow_overrides() {
  const auto due = [&](Override& which) {
    if (which.target == 0 || which.reported == which.target) return false;
    if (which.stepped != Time{} && now_ - which.stepped < kOverrideSettle) return false;
    which.stepped = now_;
    return true;
  };
  const auto step = [&](Override& which, const OverrideBytes& bytes) {
    if (!due(which)) return;
    const int far = which.target - (which.reported > 0 ? which.reported : 100);
    for (int i = 0; i < std::abs(far) / 10; ++i) urge(static_cast<char>(far > 0 ? bytes.up10 : bytes.down10));
    for (int i = 0; i < std::abs(far) % 10; ++i) urge(static_cast<char>(far > 0 ? bytes.up1 : bytes.down1));
  };
  step(feed_, kFeedBytes);
  step(spindle_, kSpindleBytes);
  if (due(rapid_))
    urge(static_cast<char>(rapid_.target == 100  ? kRapidFull
                           : rapid_.target == 50 ? kRapidHalf
                                                 : kRapidQuarter));
}

}  // namespace tiltfeed::daemon
