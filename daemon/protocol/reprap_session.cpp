#include "daemon/protocol/reprap_session.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "daemon/protocol/grbl_words.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Boards reset when the port opens; a bootloader and an SD card take their time.
constexpr Time kBootTimeout = seconds(15), kAskAgain = seconds(2);
/// Marlin says "busy" every two seconds while it works. After three silent ones a line or its ok was lost.
constexpr Time kSilence = seconds(6);
/// The oldest line is sent again so many times before the wire is given up.
constexpr int kMostProbes = 5;
/// Lines that may be in the command queue and the planner of the firmware (Marlin: 4 to 32, and 16 to 64).
constexpr std::size_t kFirmwareDepth = 128, kEndless = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kMostWindow = 64;
constexpr Time kLongest = milliseconds(200);

}  // namespace

std::string reprap_frame(std::uint64_t number, std::string_view text) {
  std::string frame = "N" + std::to_string(number) + std::string(text);
  unsigned char sum = 0;
  for (const char c : frame) sum = static_cast<unsigned char>(sum ^ static_cast<unsigned char>(c));
  return frame + "*" + std::to_string(sum);
}

RepRapSession::RepRapSession(const RepRapOptions& options, Time now)
    : options_(options),
      now_(now),
      opened_(now),
      asked_(now - kAskAgain),
      last_heard_(now),
      deadline_(now),
      recent_(options.positions),
      watch_(options.positions) {
  window_ = std::clamp<std::size_t>(static_cast<std::size_t>(std::max(1, options.window)), 1, kMostWindow);
}

void RepRapSession::move(Event event) {
  const std::optional<Phase> next = next_phase(phase_, event);
  assert(next);
  phase_ = *next;
}

bool RepRapSession::wants_work() const {
  if (phase_ != Phase::kRun || ended_ || history_.size() >= window_) return false;
  return history_.empty() || !history_.back().line.alone;
}

void RepRapSession::push(Line line) {
  assert(wants_work());
  watch_.push(line.number, line.text);
  watch_.executed(line.number);  // only where the last one leads is asked for
  append(std::move(line), Kind::kLine);
}

void RepRapSession::append(Line line, Kind kind) {
  if (history_.empty()) last_heard_ = now_;
  history_.push_back({next_number_++, std::move(line), kind});
}

/// Puts lines into out_ up to the window. A line that travels alone waits until it is the oldest.
void RepRapSession::write_due() {
  if (now_ < quiet_until_) return;
  while (due_ < next_number_ && out_.size() < kMaxReplyLine) {
    const std::uint64_t first = next_number_ - history_.size();
    if (due_ < first || due_ - first >= window_) return;
    const Numbered& next = history_[due_ - first];
    if (next.line.alone && due_ != first) return;
    if (due_ > first && history_[due_ - first - 1].line.alone) return;
    out_ += reprap_frame(next.number, next.line.text) + "\n";
    rounds_begun_ = true;
    if (next.kind == Kind::kLine) touched_ = std::max(touched_, next.line.number);
    if (next.line.waits && phase_ == Phase::kRun) move(Event::kOperatorStop);
    ++due_;
  }
}

std::string_view RepRapSession::output(Time now) {
  now_ = now;
  deadline_ = now + kLongest;
  if (is_final(phase_)) return out_;
  if (phase_ == Phase::kConnect && now_ - asked_ >= kAskAgain) {
    // The empty line ends whatever fragment is left in the firmware.
    out_ += "\n" + reprap_frame(0, "M110N0") + "\n";
    asked_ = now_;
  }
  if (phase_ == Phase::kRun && ended_ && history_.empty()) {
    append({0, "M400"}, Kind::kBarrier);
    move(Event::kAllSent);
  }
  if (phase_ != Phase::kConnect) write_due();
  if (now < quiet_until_) deadline_ = quiet_until_;
  return out_;
}

void RepRapSession::sent(std::size_t count) {
  assert(count <= out_.size());
  out_.erase(0, count);
}

void RepRapSession::receive(std::string_view bytes, Time now) {
  now_ = now;
  while (!bytes.empty() && !is_final(phase_)) {
    const std::size_t lf = bytes.find('\n');
    partial_ += bytes.substr(0, lf);
    if (partial_.size() > kMaxReplyLine) partial_.assign("overlong reply");
    if (lf == bytes.npos) break;
    bytes.remove_prefix(lf + 1);
    std::string line;
    line.swap(partial_);
    if (line.ends_with('\r')) line.pop_back();
    if (!line.empty()) on_line(line);
  }
  if (!is_final(phase_)) check_time();
}

void RepRapSession::on_line(std::string_view line) {
  last_text_ = wire_text(line);
  const RepRapReply reply = parse_reprap_reply(line);
  const bool after_resend = std::exchange(resend_ok_due_, false);
  if (reply.kind == RepRapReplyKind::kHalted) {
    loss_ = Loss::kRestarted;
    return fault(Code::kLink, "the firmware has halted: '" + last_text_ + "'" + marlin_meaning(line) +
                                  "; home the machine before anything else");
  }
  if (phase_ == Phase::kConnect || phase_ == Phase::kIdentify) return on_opening(reply, line);
  switch (reply.kind) {
    case RepRapReplyKind::kOk:
      last_heard_ = now_;
      if (!after_resend || reply.line) on_ok(reply);
      return;
    case RepRapReplyKind::kResend:
      return on_resend(reply);
    case RepRapReplyKind::kError:
      last_line_ = reply.line;
      resend_ok_due_ = true;  // even if the resend that follows is damaged
      return;
    case RepRapReplyKind::kBusy:
      last_heard_ = now_;
      machine_ = reply.paused ? "Paused" : "Busy";
      return;
    case RepRapReplyKind::kStart:
      loss_ = Loss::kRestarted;
      return fault(Code::kLink, "the firmware has restarted; home the machine before anything else");
    default:
      return take_place(line);
  }
}

void RepRapSession::on_opening(const RepRapReply& reply, std::string_view line) {
  if (reply.kind == RepRapReplyKind::kStart) {
    asked_ = now_ - kAskAgain;  // what was asked before is gone
    return;
  }
  if (phase_ == Phase::kConnect) {
    if (reply.kind != RepRapReplyKind::kOk || asked_ == opened_ - kAskAgain) return;
    move(Event::kAnswered);
    last_heard_ = now_;
    return append({0, "M115"}, Kind::kProbe);
  }
  if (reply.kind == RepRapReplyKind::kIdentity) {
    numbers_known_ = true;
    if (line.starts_with("FIRMWARE_NAME:")) firmware_ = wire_text(line.substr(14, 60));
    if (line == "Cap:EMERGENCY_PARSER:1") emergency_ = true;
    return;
  }
  if (reply.kind == RepRapReplyKind::kError) last_line_ = reply.line;
  if (reply.kind == RepRapReplyKind::kResend) return on_resend(reply);
  // Without its name this is the ok of something older, or of our repeated M110.
  if (reply.kind != RepRapReplyKind::kOk || !numbers_known_ || history_.empty()) return;
  if (options_.window == 0 && reply.free_commands)
    window_ = std::clamp<std::size_t>(static_cast<std::size_t>(*reply.free_commands) + 1, 1, kMostWindow);
  settle_front();
  move(Event::kReady);
}

void RepRapSession::on_ok(const RepRapReply& reply) {
  machine_ = "Ready";
  probes_ = 0;
  const std::uint64_t first = next_number_ - history_.size();
  if (reply.line && *reply.line >= first && *reply.line < due_) {  // it says which line it means
    owed_ = 0;
    return settle_before(*reply.line + 1);
  }
  if (reply.line) return;
  if (owed_ > 0) {
    --owed_;
    return;
  }
  if (history_.empty() || due_ <= first) return;  // an ok too many: the numbers will tell
  settle_front();
}

void RepRapSession::settle_before(std::uint64_t number) {
  while (!history_.empty() && history_.front().number < number && !is_final(phase_)) settle_front();
}

void RepRapSession::settle_front() {
  const Numbered settled = history_.front();
  settled_.push_back(std::move(history_.front()));
  if (settled_.size() > kMostWindow) settled_.pop_front();
  history_.pop_front();
  due_ = std::max(due_, settled.number + 1);
  if (settled.kind == Kind::kLine) {
    ++acknowledged_;
    // After a quick stop all planned lines stay in doubt, and so do those that are answered since.
    recent_.settle(settled.line.number, settled.line.text, quick_stopped_ ? kEndless : kFirmwareDepth,
                   [](std::uint64_t) {});
    if (settled.line.waits && phase_ == Phase::kToolChange) move(Event::kOperatorDone);
  }
  if (settled.kind != Kind::kBarrier && settled.kind != Kind::kPlace) return;
  if (phase_ == Phase::kHold) move(Event::kResumed), move(Event::kAllSent);
  if (phase_ == Phase::kStop && settled.kind == Kind::kBarrier && history_.empty()) {
    if (!quick_stopped_) recent_.clear();
    error_ = {
        Code::kCancelled,
        "stopped on request; " + (quick_stopped_ ? describe(state()) : "all lines that were sent have run")};
    move(Event::kStood);
  } else if (phase_ == Phase::kDrain) {
    settled.kind == Kind::kBarrier ? ask_place() : prove_end();
  }
}

void RepRapSession::check_time() {
  if (is_opening(phase_) && now_ - opened_ >= kBootTimeout)
    return fault(Code::kLink, last_text_.empty()
                                  ? "no answer within 15 s; check the power, the cable and the baud rate"
                                  : "what answers does not speak RepRap (last heard: '" + last_text_ +
                                        "'); check the baud rate");
  if (phase_ == Phase::kConnect) return;
  if (history_.empty() || now_ - last_heard_ < kSilence || phase_ == Phase::kToolChange) return;
  double dwell = 0.0;
  for (const Numbered& open : history_) dwell += open.line.dwell;
  if (now_ - last_heard_ < kSilence + time_of(dwell)) return;
  if (++probes_ > kMostProbes) {
    loss_ = Loss::kWire;
    return fault(Code::kLink, "the firmware has not answered for 30 s");
  }
  // The oldest line once more: a firmware that has it says so by asking for a later one.
  due_ = next_number_ - history_.size();
  owed_ = 0;
  probing_ = true;
  ++resends_;
  last_heard_ = now_;
}

void RepRapSession::link_lost(const Error& error) {
  if (is_final(phase_)) return;
  loss_ = Loss::kWire;
  fault(error.code, error.message);
}

LineRange RepRapSession::uncertain() const {
  LineRange range;
  if (!recent_.empty()) range = {recent_.first(), recent_.last()};
  for (const Numbered& open : history_) {
    if (open.kind != Kind::kLine || open.line.number > touched_) continue;
    if (range.first == 0) range.first = open.line.number;
    range.last = open.line.number;
  }
  return range;
}

void RepRapSession::fault(Code code, const std::string& what) {
  error_ = {code, is_opening(phase_) ? what : what + "; " + describe(state())};
  move(Event::kFailed);
  out_.clear();
}

SendState RepRapSession::state() const {
  SendState state;
  state.phase = phase_;
  state.total = options_.total;
  state.acknowledged = state.sent = options_.before + acknowledged_;
  for (const Numbered& open : history_)
    state.sent += open.kind == Kind::kLine && open.line.number <= touched_;
  state.executed = state.acknowledged - recent_.size();
  state.resends = resends_;
  state.machine = machine_;
  if (phase_ != Phase::kDone) state.uncertain = uncertain();
  state.refused = refused_;
  state.loss = loss_;
  return state;
}

}  // namespace tiltfeed::daemon
