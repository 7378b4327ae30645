// What a Grbl session can say about itself: progress, and which lines may have run.

#include <algorithm>

#include "daemon/protocol/grbl_session.h"

namespace tiltfeed::daemon {

namespace {

/// When the controller does not tell its planner's depth: more than any known (grblHAL 100 to 1000).
constexpr std::size_t kUnknownPlanner = 1024;

/// A reset ends check mode; the next program must not meet it.
constexpr char kLeaveCheck = 0x18;

}  // namespace

/// Every settled motion line is executed or holds a planner block (or a step segment).
std::size_t GrblSession::planner_depth() const {
  return (buffers_.planner > 0 ? static_cast<std::size_t>(buffers_.planner) : kUnknownPlanner) +
         kStepSegments;
}

bool GrblSession::reached_wire(const Flight& flight) const {
  return flight.end - flight.line.text.size() - 1 < taken_;
}

LineRange GrblSession::uncertain() const {
  LineRange range;
  if (is_opening(phase_)) return range;
  if (stood_) return stood_->lines;
  if (!recent_.empty()) range = {recent_.first(), recent_.last()};
  for (const Flight& flight : in_flight_) {
    if (flight.kind != Kind::kLine || !reached_wire(flight)) break;
    if (range.first == 0) range.first = flight.line.number;
    range.last = flight.line.number;
  }
  return range;
}

void GrblSession::fault(Code code, const std::string& what, bool hold, Event event) {
  const bool opening = (is_opening(phase_) && !left_check_) || code == Code::kLimit;
  const bool checking = phase_ == Phase::kCheck && !left_check_;
  move(event);
  error_ = {code, opening ? what : what + "; " + describe(state())};
  if (checking) {  // what was read was not run
    error_.message += "; nothing has moved";
    in_flight_.clear();
    recent_.clear();
    in_flight_bytes_ = acknowledged_ = 0;
  }
  out_.clear();
  urgent_ = 0;
  if (checking && event != Event::kAlarm) urge(kLeaveCheck);
  if (hold && !opening) urge('!');  // the lines in the controller would run on otherwise
}

/// By its last report: no block is planned, and too few bytes have come for a line. A dwell and a spindle
/// that gets up to speed leave no block either, but lines behind them wait.
std::optional<bool> GrblSession::starved() const {
  if (phase_ != Phase::kRun || buffers_.planner <= 0 || status_.planner_free < 0 || acknowledged_ == 0)
    return std::nullopt;
  return !ended_ && status_.planner_free >= buffers_.planner &&
         2 * status_.receive_free >= largest_receive_free_;
}

SendState GrblSession::state() const {
  SendState state;
  state.phase = phase_;
  state.total = options_.total;
  state.sent = state.acknowledged = state.executed = options_.before;
  state.machine = status_.state;
  state.feed_override = feed_.reported;
  state.rapid_override = rapid_.reported;
  state.spindle_override = spindle_.reported;
  state.feed = status_.feed, state.spindle = status_.spindle;
  state.starved = starved();
  state.refused = refused_;
  state.place = place().value_or(no_axes());
  if (phase_ == Phase::kHold)
    state.held = held_on_request_ ? "held on request" : "held at the machine; a resume goes on";
  state.loss = loss_;
  if (status_.line > 0) state.line = static_cast<std::uint64_t>(status_.line);
  if (is_opening(phase_)) return state;
  state.acknowledged += acknowledged_;
  state.sent = state.acknowledged;
  for (const Flight& flight : in_flight_)
    if (flight.kind == Kind::kLine && reached_wire(flight)) ++state.sent;
  state.executed = state.acknowledged - recent_.size();
  if (stood_) {  // lines behind the one where the axes stand were taken over and have gone with the reset
    state.executed = stood_->executed, state.sent = stood_->sent;
    state.acknowledged = std::clamp(state.acknowledged, state.executed, state.sent);
  }
  if (phase_ != Phase::kDone) state.uncertain = uncertain();
  return state;
}

}  // namespace tiltfeed::daemon
