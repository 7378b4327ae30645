// What the operator orders, as far as the firmware can do it.

#include <algorithm>

#include "daemon/protocol/reprap_session.h"

namespace tiltfeed::daemon {

void RepRapSession::command(const OperatorCommand& command, Time now) {
  now_ = now;
  const Answer answer = answer_to(command.order, phase_);
  refused_ = refusal_text(answer);
  if (answer == Answer::kEnd) {
    error_ = {Code::kCancelled, "stopped on request; nothing has moved"};
    move(Event::kStood);
    out_ = command.order == Order::kAbort ? "M112\n" : "";
    return;
  }
  if (answer != Answer::kObey) return;
  switch (command.order) {
    case Order::kHold:
      refused_ = "this firmware has no feed hold: the machine stands after the lines that it has";
      return move(Event::kHeld);
    case Order::kResume:
      if (phase_ == Phase::kHold) {
        move(Event::kResumed);
        if (!history_.empty() &&
            (history_.back().kind == Kind::kBarrier || history_.back().kind == Kind::kPlace))
          move(Event::kAllSent);
      } else {
        out_ = "M108\n" + out_;
      }
      return;
    case Order::kStop:
      return ask_stop();
    case Order::kAbort:
      loss_ = Loss::kRestarted;
      fault(Code::kCancelled, "aborted on request: the firmware was halted, restart and home it first");
      out_ = "M112\n";
      return;
    case Order::kFeedOverride:
      if (phase_ == Phase::kRun)
        return append({0, "M220S" + std::to_string(std::clamp(command.value, kMinOverride, kMaxOverride))},
                      Kind::kInserted);
      refused_ = "only while the program runs";
      return;
    case Order::kRapidOverride:
    case Order::kSpindleOverride:
      refused_ = "this firmware has a feed override only";
  }
}

/// Lines that have not left are forgotten; with an emergency parser the machine stops at once, else after the
/// lines that it has. Then spindle and coolant are turned off, and M400 proves that it stands. The wait of M0
/// is ended first: nothing is read behind it.
void RepRapSession::ask_stop() {
  const bool waits = phase_ == Phase::kToolChange;
  move(Event::kStopAsked);
  quick_stopped_ = emergency_;
  if (emergency_) out_ += waits ? "M108\nM410\n" : "M410\n";
  if (waits && !emergency_)
    refused_ =
        "the firmware waits for its operator and hears nothing meanwhile: press its button, then it stops";
  while (!history_.empty() && history_.back().number >= due_) {
    history_.pop_back();
    --next_number_;
  }
  for (const char* off : {"M5", "M9"}) append({0, off}, Kind::kInserted);
  append({0, "M400"}, Kind::kBarrier);
}

}  // namespace tiltfeed::daemon
