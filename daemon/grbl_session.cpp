#include "daemon/grbl_session.h"

#include <algorithm>
#include <cassert>

namespace tiltfeed {

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
/// Blocks that have left the planner but are still in the step segment buffer (10 segments on grblHAL).
constexpr std::size_t kStepSegments = 16;
/// When the controller does not tell its planner's depth: more than any known (grblHAL 100 to 1000).
constexpr std::size_t kUnknownPlanner = 1024;
/// A reply line is shorter on every known firmware; longer ones are noise.
constexpr std::size_t kMaxReply = 1024;
constexpr std::string_view kBarrier = "G4P0";

}  // namespace

GrblSession::GrblSession(const GrblOptions& options, Time now)
    : options_(options), now_(now), opened_(now), next_poll_(now), last_report_(now), last_progress_(now) {}

void GrblSession::write(std::string_view bytes) {
  out_ += bytes;
  written_ += bytes.size();
}

bool GrblSession::wants_work() const {
  if (phase_ != Phase::kStreaming || ended_ || next_) return false;
  if (!in_flight_.empty() && in_flight_.back().line.alone) return false;
  // Ask again when an eighth of the window is free: fewer, larger writes, and seven eighths stay full.
  return window_ - in_flight_bytes_ >= window_ / 8;
}

void GrblSession::push(Line line) {
  assert(wants_work());
  next_ = std::move(line);
  move_next();
}

/// Puts the next line, and at the end the barrier, on its way if the window has room.
void GrblSession::move_next() {
  if (phase_ != Phase::kStreaming || (!next_ && !ended_)) return;
  if (!in_flight_.empty() && (in_flight_.back().line.alone || (next_ && next_->alone))) return;
  Flight flight;
  flight.barrier = !next_;
  if (flight.barrier) flight.line.text = kBarrier;
  const std::size_t size = (next_ ? next_->text.size() : kBarrier.size()) + 1;
  if (in_flight_bytes_ + size > window_) return;
  if (next_) flight.line = std::move(*next_);
  next_.reset();
  if (in_flight_.empty()) last_progress_ = now_;
  write(flight.line.text);
  write("\n");
  flight.end = written_;
  in_flight_bytes_ += size;
  if (flight.barrier) phase_ = Phase::kDraining;
  in_flight_.push_back(std::move(flight));
}

std::string_view GrblSession::output(Time now) {
  now_ = now;
  if (phase_ == Phase::kDone || phase_ == Phase::kFault) return out_;
  move_next();
  if (now_ >= next_poll_) {
    // A question mark is taken out of the stream at once and counts towards no buffer. When the wire is
    // stuck the last one has not even left.
    if (out_.empty() || out_.back() != '?') write("?");
    next_poll_ = now_ + kPollInterval;
  }
  return out_;
}

void GrblSession::sent(std::size_t count) {
  assert(count <= out_.size());
  out_.erase(0, count);
  taken_ += count;
}

void GrblSession::receive(std::string_view bytes, Time now) {
  now_ = now;
  while (!bytes.empty() && phase_ != Phase::kFault && phase_ != Phase::kDone) {
    const std::size_t lf = bytes.find('\n');
    if (lf == bytes.npos) {
      partial_ += bytes;
      if (partial_.size() > kMaxReply) partial_.assign("overlong reply");
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
  if (phase_ == Phase::kOpening) check_opening_time();
  if (phase_ == Phase::kStreaming || phase_ == Phase::kDraining) check_running_time();
}

void GrblSession::on_line(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (line.empty()) return;
  const GrblReplyKind kind = classify_reply(line);
  if (phase_ == Phase::kOpening)
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
  status_ = std::move(*status);
  status_seen_ = true;
  if (status_.state.starts_with("Alarm")) {
    const bool opening = phase_ == Phase::kOpening;
    fault(Code::kLink,
          opening ? "the machine is in alarm; home it ($H) or unlock it ($X) first: nothing was sent"
                  : "the machine is in alarm",
          false);
  }
}

void GrblSession::on_running_line(GrblReplyKind kind, std::string_view line) {
  const std::string text(line.substr(0, 80));
  switch (kind) {
    case GrblReplyKind::kOk:
      return on_ok();
    case GrblReplyKind::kStatus:
      return on_status(line);
    case GrblReplyKind::kFeedback:
      return;
    case GrblReplyKind::kError:
      if (in_flight_.empty()) return fault(Code::kLink, "'" + text + "' with no line on its way", true);
      return fault(Code::kLink,
                   "the controller answers '" + text + "' to " +
                       (in_flight_.front().barrier
                            ? "the final " + in_flight_.front().line.text
                            : quote_line(in_flight_.front().line.number, in_flight_.front().line.text)),
                   true);
    case GrblReplyKind::kAlarm:
      return fault(Code::kLink, "the controller reports '" + text + "'", false);
    case GrblReplyKind::kBanner:
      return fault(Code::kLink, "the controller has restarted ('" + text + "'); home it before anything else",
                   false);
    case GrblReplyKind::kGarbled:
      if (line.front() == '<') return;  // a damaged report is asked for again; an ok that it ate is missed
      return fault(Code::kLink, "unrecognised reply '" + text + "': the line is disturbed", true);
  }
}

void GrblSession::on_ok() {
  if (in_flight_.empty() || in_flight_.front().end > taken_)
    return fault(Code::kLink, "one ok more than lines sent: a line was cut in two on its way", true);
  last_progress_ = now_;
  Flight& flight = in_flight_.front();
  in_flight_bytes_ -= flight.line.text.size() + 1;
  if (flight.barrier) {
    phase_ = Phase::kDone;
  } else {
    ++acknowledged_;
    recent_.push_back(flight.line.number);
    if (recent_.size() > planner_depth()) recent_.pop_front();
  }
  in_flight_.pop_front();
}

bool GrblSession::waiting_for_operator() const {
  for (const std::string_view state : {"Hold", "Door", "Tool", "Home"})
    if (status_.state.starts_with(state)) return true;
  return false;
}

void GrblSession::check_running_time() {
  if (now_ - last_report_ >= kReportTimeout)
    return fault(Code::kLink, "the controller has not answered a status request for 5 s", true);
  if (in_flight_.empty() || waiting_for_operator()) return;
  Time allowed = status_.state == "Run" ? kRunStallTimeout : kStallTimeout;
  for (const Flight& flight : in_flight_)
    allowed += std::chrono::duration_cast<Time>(std::chrono::duration<double>(flight.line.dwell));
  if (now_ - last_progress_ >= allowed)
    fault(Code::kLink,
          std::to_string(in_flight_.size()) + " lines are not answered, oldest " +
              quote_line(in_flight_.front().line.number, in_flight_.front().line.text) +
              ", and the machine (" + status_.state + ") makes no progress: an ok or a line was lost",
          true);
}

void GrblSession::stop() {
  if (phase_ != Phase::kDone && phase_ != Phase::kFault) fault(Code::kLink, "stopped on request", true);
}

void GrblSession::link_lost(const Error& error) { fault(error.code, error.message, false); }

// ---- reports -------------------------------------------------------------------------------------------

/// Every settled motion line is executed or holds a planner block (or a step segment).
std::size_t GrblSession::planner_depth() const {
  return (buffers_.planner > 0 ? static_cast<std::size_t>(buffers_.planner) : kUnknownPlanner) +
         kStepSegments;
}

bool GrblSession::reached_wire(const Flight& flight) const {
  return flight.end - flight.line.text.size() - 1 < taken_;
}

std::string GrblSession::uncertain_lines() const {
  std::uint64_t first = recent_.empty() ? 0 : recent_.front();
  std::uint64_t last = recent_.empty() ? 0 : recent_.back();
  for (const Flight& flight : in_flight_) {
    if (flight.barrier || !reached_wire(flight)) break;
    if (first == 0) first = flight.line.number;
    last = flight.line.number;
  }
  if (first == 0) return "no line was sent";
  return "lines " + std::to_string(first) + " to " + std::to_string(last) +
         " may have run; earlier ones have, later ones have not";
}

void GrblSession::fault(Code code, const std::string& what, bool hold) {
  const bool opening = phase_ == Phase::kOpening || code == Code::kLimit;
  error_ = {code, opening ? what : what + "; " + uncertain_lines()};
  phase_ = Phase::kFault;
  out_.clear();
  if (hold && !opening) out_ = "!";  // the lines in the controller would run on otherwise
}

SendState GrblSession::state() const {
  SendState state;
  state.phase = phase_;
  state.total = options_.total;
  state.acknowledged = acknowledged_;
  state.sent = acknowledged_;
  for (const Flight& flight : in_flight_)
    if (!flight.barrier && flight.end <= taken_) ++state.sent;
  const std::uint64_t open = recent_.size();
  state.executed = phase_ == Phase::kDone ? acknowledged_ : acknowledged_ - open;
  state.machine = status_.state;
  return state;
}

}  // namespace tiltfeed
