#include "daemon/protocol/session.h"

#include <algorithm>

namespace tiltfeed::daemon {

namespace {

struct Transition {
  Phase from;
  Event event;
  Phase to;
};

constexpr Transition kTransitions[] = {
    {Phase::kConnect, Event::kAnswered, Phase::kIdentify},
    {Phase::kIdentify, Event::kCheckBegins, Phase::kCheck},
    {Phase::kCheck, Event::kChecked, Phase::kConnect},
    {Phase::kIdentify, Event::kReady, Phase::kRun},
    {Phase::kRun, Event::kHeld, Phase::kHold},
    {Phase::kDrain, Event::kHeld, Phase::kHold},
    {Phase::kHold, Event::kResumed, Phase::kRun},
    {Phase::kRun, Event::kOperatorStop, Phase::kToolChange},
    {Phase::kHold, Event::kOperatorStop, Phase::kToolChange},
    {Phase::kDrain, Event::kOperatorStop, Phase::kToolChange},
    {Phase::kToolChange, Event::kHeld, Phase::kHold},
    {Phase::kToolChange, Event::kOperatorDone, Phase::kRun},
    {Phase::kRun, Event::kAllSent, Phase::kDrain},
    {Phase::kDrain, Event::kProved, Phase::kDone},
    {Phase::kRun, Event::kStopAsked, Phase::kStop},
    {Phase::kHold, Event::kStopAsked, Phase::kStop},
    {Phase::kToolChange, Event::kStopAsked, Phase::kStop},
    {Phase::kDrain, Event::kStopAsked, Phase::kStop},
    {Phase::kConnect, Event::kStood, Phase::kStopped},
    {Phase::kIdentify, Event::kStood, Phase::kStopped},
    {Phase::kCheck, Event::kStood, Phase::kStopped},
    {Phase::kStop, Event::kStood, Phase::kStopped},
};

}  // namespace

bool is_final(Phase phase) {
  return phase == Phase::kDone || phase == Phase::kStopped || phase == Phase::kAlarm ||
         phase == Phase::kFault;
}

bool is_opening(Phase phase) {
  return phase == Phase::kConnect || phase == Phase::kIdentify || phase == Phase::kCheck;
}

std::optional<Phase> next_phase(Phase phase, Event event) {
  if (is_final(phase)) return std::nullopt;
  if (event == Event::kFailed) return Phase::kFault;
  if (event == Event::kAlarm) return Phase::kAlarm;
  for (const Transition& transition : kTransitions)
    if (transition.from == phase && transition.event == event) return transition.to;
  return std::nullopt;
}

const char* phase_name(Phase phase) {
  constexpr const char* kNames[] = {"connect", "identify", "check", "run",     "hold",  "operator stop",
                                    "drain",   "stop",     "done",  "stopped", "alarm", "fault"};
  return kNames[static_cast<int>(phase)];
}

const char* event_name(Event event) {
  constexpr const char* kNames[] = {"answered",   "check begins",  "checked",       "ready",    "held",
                                    "resumed",    "operator stop", "operator done", "all sent", "proved",
                                    "stop asked", "stood",         "alarm",         "failed"};
  return kNames[static_cast<int>(event)];
}

const char* loss_name(Loss loss) {
  constexpr const char* kNames[] = {"none", "wire", "restarted", "forgotten"};
  return kNames[static_cast<int>(loss)];
}

Answer answer_to(Order order, Phase phase) {
  if (is_final(phase)) return Answer::kIgnore;
  const bool waits = phase == Phase::kHold || phase == Phase::kToolChange;
  switch (order) {
    case Order::kHold:
      if (is_opening(phase)) return Answer::kNothingYet;
      return waits || phase == Phase::kStop ? Answer::kIgnore : Answer::kObey;
    case Order::kResume:
      return waits ? Answer::kObey : Answer::kNotHeld;
    case Order::kStop:
      if (is_opening(phase)) return Answer::kEnd;
      return phase == Phase::kStop ? Answer::kIgnore : Answer::kObey;
    case Order::kAbort:
      return is_opening(phase) ? Answer::kEnd : Answer::kObey;
    case Order::kFeedOverride:
    case Order::kRapidOverride:
    case Order::kSpindleOverride:
      if (is_opening(phase)) return Answer::kNothingYet;
      return phase == Phase::kStop ? Answer::kIgnore : Answer::kObey;
  }
  return Answer::kIgnore;
}

const char* refusal_text(Answer answer) {
  if (answer == Answer::kNotHeld) return "the machine is not held";
  if (answer == Answer::kNothingYet) return "nothing moves yet";
  return "";
}

std::string quote_line(std::uint64_t number, const std::string& text) {
  return "line " + std::to_string(number) + " '" + text + "'";
}

std::string numbered(const std::string& of, const LineRange& range) {
  if (range.first >= range.last) return of + " " + std::to_string(range.first);
  return of + "s " + std::to_string(range.first) + " to " + std::to_string(range.last);
}

std::string describe(const SendState& state) {
  if (state.sent == 0) return "no line was sent";
  // The counts decide: that no lines can be named proves nothing.
  if (state.executed >= state.sent)
    return "all " + std::to_string(state.sent) + " blocks that were sent have run";
  const LineRange& lines = state.uncertain;
  return numbered("block", {state.executed + 1, state.sent}) + " may have run" +
         (lines.first == 0 ? "" : " (" + numbered("line", lines) + " of the file)") +
         (state.elsewhere ? "; earlier ones may not have" : "; earlier ones have") + ", later ones have not";
}

}  // namespace tiltfeed::daemon
