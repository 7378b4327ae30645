#include "daemon/protocol/grbl_session.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "daemon/protocol/grbl_words.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Status polling: fast enough for a progress display, 1 % of a 115200 line.
constexpr Time kPollInterval = milliseconds(200);
/// A status report takes milliseconds; five seconds without one mean a dead link or controller.
constexpr Time kReportTimeout = seconds(5);
/// Neither ok nor any change in status: longer than a spindle takes to run up.
constexpr Time kStallTimeout = seconds(10);
/// The same while the machine says Run: a slow block may not show in the printed position.
constexpr Time kRunStallTimeout = seconds(300);
constexpr std::string_view kBarrier = "G4P0";

}  // namespace

GrblSession::GrblSession(const GrblOptions& options, Time now)
    : options_(options),
      now_(now),
      opened_(now),
      recent_(options.positions),
      watch_(options.positions),
      next_poll_(now),
      last_report_(now),
      last_progress_(now) {}

void GrblSession::move(Event event) {
  const std::optional<Phase> next = next_phase(phase_, event);
  assert(next);
  phase_ = *next;
}

void GrblSession::write(std::string_view bytes) {
  out_ += bytes;
  written_ += bytes.size();
}

/// Real-time bytes are taken out of the stream at once and count towards no buffer, so they go in front of
/// everything that has not left.
void GrblSession::urge(char byte) { out_.insert(urgent_++, 1, byte); }

bool GrblSession::wants_work() const {
  if ((phase_ != Phase::kRun && phase_ != Phase::kCheck) || ended_ || next_) return false;
  if (phase_ == Phase::kCheck && !check_proved_) return false;
  if (!in_flight_.empty() && (in_flight_.back().line.alone || in_flight_.back().kind != Kind::kLine))
    return false;
  // Ask again when an eighth of the window is free: fewer, larger writes, and seven eighths stay full.
  return window_ - in_flight_bytes_ >= window_ / 8;
}

void GrblSession::push(Line line) {
  assert(wants_work());
  if (numbers_lines_ && line.text.front() != 'N') line.text.insert(0, "N" + std::to_string(line.number));
  if (phase_ == Phase::kRun) watch_.push(line.number, line.text);
  if (first_checked_ == 0) first_checked_ = line.number;
  next_ = std::move(line);
  move_next();
}

/// Puts the next line, and at the end the barrier, on its way if the window has room.
void GrblSession::move_next() {
  if ((phase_ != Phase::kRun && phase_ != Phase::kCheck) || (!next_ && !ended_)) return;
  if (!in_flight_.empty()) {
    const Flight& last = in_flight_.back();
    if (last.kind != Kind::kLine || last.line.alone || (next_ && next_->alone)) return;
  }
  if (next_) {
    const bool waits = next_->waits;
    if (!put(*next_, Kind::kLine)) return;
    next_.reset();
    if (waits && phase_ == Phase::kRun) move(Event::kOperatorStop);
  } else if (put({0, std::string(kBarrier)}, Kind::kBarrier) && phase_ == Phase::kRun) {
    move(Event::kAllSent);
  }
}

/// False when the window has no room.
bool GrblSession::put(Line line, Kind kind) {
  const std::size_t size = line.text.size() + 1;
  if (in_flight_bytes_ + size > window_) return false;
  if (in_flight_.empty()) last_progress_ = now_;
  write(line.text);
  write("\n");
  in_flight_bytes_ += size;
  in_flight_.push_back({std::move(line), written_, kind});
  return true;
}

std::string_view GrblSession::output(Time now) {
  now_ = now;
  if (is_final(phase_)) return out_;
  move_next();
  if (now_ >= next_poll_) {
    // When the wire is stuck the last one has not even left.
    if (out_.find('?') == out_.npos) urge('?');
    next_poll_ = now_ + kPollInterval;
  }
  return out_;
}

void GrblSession::sent(std::size_t count) {
  assert(count <= out_.size());
  out_.erase(0, count);
  const std::size_t urgent = std::min(count, urgent_);
  urgent_ -= urgent;
  taken_ += count - urgent;
}

void GrblSession::receive(std::string_view bytes, Time now) {
  now_ = now;
  while (!bytes.empty() && !is_final(phase_)) {
    const std::size_t lf = bytes.find('\n');
    if (lf == bytes.npos) {
      partial_ += bytes;
      if (partial_.size() > kMaxReplyLine) partial_.assign("overlong reply");
      break;
    }
    if (partial_.empty()) {
      on_line(bytes.substr(0, lf));
    } else {
      partial_ += bytes.substr(0, lf);
      const std::string line = std::move(partial_);
      partial_.clear();
      on_line(line);
    }
    bytes.remove_prefix(lf + 1);
  }
  if (phase_ == Phase::kConnect || phase_ == Phase::kIdentify) check_opening_time();
  if (phase_ == Phase::kCheck || (!is_opening(phase_) && !is_final(phase_))) check_running_time();
}

void GrblSession::on_line(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (line.empty()) return;
  const GrblReplyKind kind = classify_reply(line);
  if (phase_ == Phase::kConnect || phase_ == Phase::kIdentify)
    on_opening_line(kind, line);
  else
    on_running_line(kind, line);
}

// ---- streaming -----------------------------------------------------------------------------------------

void GrblSession::on_status(std::string_view line) {
  std::optional<GrblStatus> status = parse_status(line);
  if (!status) return;
  last_report_ = now_;
  if (status->state != status_.state || status->position != status_.position ||
      status->planner_free != status_.planner_free || status->receive_free != status_.receive_free)
    last_progress_ = now_;
  largest_receive_free_ = std::max(largest_receive_free_, status->receive_free);
  if (status->feed_override > 0) feed_.reported = status->feed_override;
  if (status->rapid_override > 0) rapid_.reported = status->rapid_override;
  if (status->spindle_override > 0) spindle_.reported = status->spindle_override;
  status_ = std::move(*status);
  status_seen_ = true;
  take_offset();
  if (status_.state.starts_with("Alarm"))
    return fault(Code::kLink,
                 is_opening(phase_) && phase_ != Phase::kCheck
                     ? "the machine is in alarm; home it ($H) or unlock it ($X) first: nothing was sent"
                     : "the machine is in alarm",
                 false, Event::kAlarm);
  if (phase_ == Phase::kCheck) return follow_check();
  if (is_opening(phase_)) return;
  follow_line_number();
  if (phase_ == Phase::kStop) return follow_stop();
  follow_position();
  if (is_final(phase_)) return;
  follow_hold();
  follow_overrides();
  prove_end();
}

void GrblSession::on_running_line(GrblReplyKind kind, std::string_view line) {
  const std::string text = wire_text(line);
  switch (kind) {
    case GrblReplyKind::kOk:
      return on_ok();
    case GrblReplyKind::kStatus:
      return on_status(line);
    case GrblReplyKind::kFeedback:
      return;
    case GrblReplyKind::kError:
      if (phase_ == Phase::kStop) return;
      return fault(Code::kLink, refusal(text), phase_ != Phase::kCheck);
    case GrblReplyKind::kAlarm:
      loss_ = Loss::kForgotten;
      return fault(Code::kLink, "the controller reports '" + text + "'" + reply_meaning(line), false,
                   Event::kAlarm);
    case GrblReplyKind::kBanner:
      if (phase_ == Phase::kStop && reset_sent_) return finish_stop();
      if (phase_ == Phase::kCheck && checked_) return restart_after_check();
      loss_ = Loss::kRestarted;
      return fault(Code::kLink, "the controller has restarted ('" + text + "'); home it before anything else",
                   false);
    case GrblReplyKind::kGarbled:
      if (line.front() == '<') return;  // a damaged report is asked for again; an ok that it ate is missed
      return fault(Code::kLink, "unrecognised reply '" + text + "': the line is disturbed", true);
  }
}

std::string GrblSession::refusal(const std::string& text) const {
  if (in_flight_.empty()) return "'" + text + "' with no line on its way";
  const Flight& oldest = in_flight_.front();
  return "the controller answers '" + text + "' to " +
         (oldest.kind == Kind::kLine ? quote_line(oldest.line.number, oldest.line.text) : oldest.line.text) +
         reply_meaning(text);
}

void GrblSession::on_ok() {
  if (in_flight_.empty() || in_flight_.front().end > taken_) {
    if (phase_ == Phase::kStop) return;  // of a line that was given up
    return fault(Code::kLink, "one ok more than lines sent: a line was cut in two on its way", true);
  }
  last_progress_ = now_;
  const Flight flight = std::move(in_flight_.front());
  in_flight_.pop_front();
  in_flight_bytes_ -= flight.line.text.size() + 1;
  switch (flight.kind) {
    case Kind::kLine:
      ++acknowledged_;
      if (phase_ == Phase::kCheck) last_checked_ = flight.line.number;
      settle(flight.line);
      if (phase_ == Phase::kToolChange && flight.line.waits) move(Event::kOperatorDone);
      return;
    case Kind::kBarrier:
      if (phase_ == Phase::kCheck) {
        put({0, "$C"}, Kind::kCheckOff);
        checked_ = true;  // leaving check mode restarts the controller
        return;
      }
      if (phase_ == Phase::kHold) move(Event::kResumed), move(Event::kAllSent);
      proving_ = phase_ == Phase::kDrain;
      proof_polls_ = 0;
      next_poll_ = now_;
      return;
    case Kind::kCheckOn:
      next_poll_ = now_;  // no line leaves before a report shows check mode
      return;
    case Kind::kCheckOff:
      return;
  }
}

/// Ln: names the line in execution: those before it have run. A report has no checksum, so it counts as far
/// as the one before agrees.
void GrblSession::follow_line_number() {
  if (!numbers_lines_ || status_.line <= 0) return;
  const auto named = static_cast<std::uint64_t>(status_.line);
  const std::uint64_t line = std::min(named, std::exchange(line_named_, named));
  const std::optional<std::size_t> before = recent_.before(line);
  if (!before) return;
  // The line that is being cut into steps: while the axes move, those before it may still be among the steps.
  const std::size_t behind = is_standing(status_.state) ? 0 : kStepSegments;
  for (std::size_t done = *before; done > behind; --done) {
    watch_.executed(recent_.first());
    recent_.forget_oldest();
  }
}

void GrblSession::settle(const Line& line) {
  recent_.settle(line.number, line.text, planner_depth(), [&](std::uint64_t ran) { watch_.executed(ran); });
}

bool GrblSession::waiting_for_operator() const {
  for (const std::string_view state : {"Hold", "Door", "Tool", "Home"})
    if (status_.state.starts_with(state)) return true;
  return phase_ == Phase::kToolChange || phase_ == Phase::kHold;
}

void GrblSession::check_running_time() {
  if (now_ - last_report_ >= kReportTimeout) {
    loss_ = Loss::kWire;
    return fault(Code::kLink, "the controller has not answered a status request for 5 s", true);
  }
  if (in_flight_.empty() || phase_ == Phase::kStop || waiting_for_operator()) return;
  Time allowed = status_.state == "Run" ? kRunStallTimeout : kStallTimeout;
  for (const Flight& flight : in_flight_) allowed += time_of(flight.line.dwell);
  if (now_ - last_progress_ >= allowed)
    fault(Code::kLink,
          std::to_string(in_flight_.size()) + " lines are not answered, oldest " +
              quote_line(in_flight_.front().line.number, in_flight_.front().line.text) +
              ", and the machine (" + status_.state + ") makes no progress: an ok or a line was lost",
          true);
}

void GrblSession::link_lost(const Error& error) {
  if (is_final(phase_)) return;
  loss_ = Loss::kWire;
  fault(error.code, error.message, false);
}

}  // namespace tiltfeed::daemon
