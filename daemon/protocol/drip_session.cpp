#include "daemon/protocol/drip_session.h"

#include <algorithm>
#include <cassert>

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;

/// Fanuc protocol B: NAK on an alarm, SYN on a reset.
constexpr char kNak = 0x15, kSyn = 0x16;
/// Text kept ready; more is read from the program when less than half of it is left.
constexpr std::size_t kReadyBytes = 4096;
constexpr Time kWait = milliseconds(50);
/// At the least this many bytes at once, or very slow lines would need a call per byte.
constexpr std::size_t kFewBytes = 2;

std::string_view end_of_block(config::EndOfBlock kind) {
  switch (kind) {
    case config::EndOfBlock::kLf:
      return "\n";
    case config::EndOfBlock::kCrLf:
      return "\r\n";
    case config::EndOfBlock::kCr:
      return "\r";
    case config::EndOfBlock::kLfCrCr:
      return "\n\r\r";
  }
  return "\n";
}

}  // namespace

DripSession::DripSession(const DripOptions& options, Time now) : options_(options), free_at_(now), now_(now) {
  const config::DripFormat& format = options_.format;
  const int bits = 1 + format.data_bits + (format.parity != config::Parity::kNone) + format.stop_bits;
  byte_time_ = Time(std::chrono::seconds(1)) * bits / options_.baud;
  if (!format.wait_for_start) start();
}

void DripSession::move(Event event) {
  const std::optional<Phase> next = next_phase(phase_, event);
  assert(next);
  phase_ = *next;
}

void DripSession::start() {
  move(Event::kAnswered);
  move(Event::kReady);
  out_.assign(static_cast<std::size_t>(options_.format.leader), '\0');
  if (options_.format.percent) out_ += "%" + std::string(end_of_block(options_.format.end_of_block));
  written_ = whole_ = out_.size();
}

bool DripSession::wants_work() const {
  return phase_ == Phase::kRun && !ended_ && out_.size() < kReadyBytes / 2;
}

void DripSession::push(Line line) {
  assert(wants_work());
  const std::size_t before = out_.size();
  out_ += line.text;
  out_ += end_of_block(options_.format.end_of_block);
  written_ += out_.size() - before;
  open_.push_back({line.number, written_});
}

void DripSession::end_of_program() {
  ended_ = true;
  const std::size_t before = out_.size();
  if (options_.format.percent) out_ += "%" + std::string(end_of_block(options_.format.end_of_block));
  out_.append(static_cast<std::size_t>(options_.format.trailer), '\0');
  written_ += out_.size() - before;
}

/// Never more than the wire sends within kDripAhead, so that a DC3 acts at once.
std::string_view DripSession::output(Time now) {
  now_ = now;
  shown_ = 0;
  if (is_final(phase_) || phase_ == Phase::kConnect || stopped_by_control_) return {};
  if (phase_ == Phase::kHold || phase_ == Phase::kStop) return {};
  if (phase_ == Phase::kRun && ended_) move(Event::kAllSent);
  if (phase_ == Phase::kDrain && out_.empty() && now_ >= free_at_) {
    move(Event::kProved);
    return {};
  }
  const Time busy = std::max(free_at_ - now_, Time::zero());
  if (busy >= kDripAhead) return {};
  const auto room = static_cast<std::size_t>((kDripAhead - busy) / byte_time_);
  if (room < kFewBytes && busy > Time::zero()) return {};
  shown_ = std::min(out_.size(), std::max(room, kFewBytes));
  return std::string_view(out_).substr(0, shown_);
}

void DripSession::sent(std::size_t count) {
  assert(count <= shown_);
  out_.erase(0, count);
  taken_ += count;
  free_at_ = std::max(free_at_, now_) + byte_time_ * static_cast<long>(count);
  const auto leaves = [this](std::uint64_t line) {
    if (first_line_ == 0) first_line_ = line;
    last_line_ = line;
  };
  while (!open_.empty() && open_.front().end <= taken_) {
    leaves(open_.front().line);
    whole_ = open_.front().end;
    open_.pop_front();
    ++lines_;
  }
  if (begun()) leaves(open_.front().line);
}

void DripSession::receive(std::string_view bytes, Time now) {
  now_ = now;
  for (const char raw : bytes) {
    if (is_final(phase_)) return;
    const char c = static_cast<char>(raw & 0x7F);  // the parity bit, where the port leaves it in
    const bool xon_xoff = options_.format.flow == config::FlowControl::kXonXoff;
    if (c == options_.format.xon) {
      stopped_by_control_ = false;
      if (phase_ == Phase::kConnect) start();
    } else if (c == options_.format.xoff && xon_xoff) {
      stopped_by_control_ = true;
    } else if (c == kNak) {
      return fault("the control reports an alarm (NAK)");
    } else if (c == kSyn) {
      loss_ = Loss::kRestarted;
      return fault("the control was reset (SYN)");
    }
  }
  if (phase_ == Phase::kStop && now_ >= free_at_) {
    error_ = {Code::kCancelled, "stopped on request; " + describe(state())};
    move(Event::kStood);
  }
}

Time DripSession::deadline() const {
  if (phase_ == Phase::kConnect || stopped_by_control_ || phase_ == Phase::kHold) return now_ + kWait;
  return std::max(free_at_ - kDripAhead / 2, now_ + byte_time_);
}

void DripSession::command(const OperatorCommand& command, Time now) {
  now_ = now;
  const Answer answer = answer_to(command.order, phase_);
  refused_ = refusal_text(answer);
  if (answer == Answer::kEnd) {
    error_ = {Code::kCancelled, "stopped on request; nothing was sent"};
    return move(Event::kStood);
  }
  if (answer != Answer::kObey) return;
  switch (command.order) {
    case Order::kHold:
      refused_ = "no feed hold over this link: the control executes what it has";
      return move(Event::kHeld);
    case Order::kResume:
      return move(Event::kResumed);
    case Order::kStop:
    case Order::kAbort:
      if (phase_ != Phase::kStop) move(Event::kStopAsked);
      return;
    default:
      refused_ = "no overrides over this link";
  }
}

void DripSession::link_lost(const Error& error) {
  if (is_final(phase_)) return;
  loss_ = Loss::kWire;
  fault(error.message);
}

void DripSession::fault(const std::string& what) {
  error_ = {Code::kLink, phase_ == Phase::kConnect ? what : what + "; " + describe(state())};
  move(Event::kFailed);
}

/// Nothing says what has run, so every line that has left may or may not have.
LineRange DripSession::uncertain() const { return {first_line_, last_line_}; }

SendState DripSession::state() const {
  SendState state;
  state.phase = phase_;
  state.total = options_.total;
  state.sent = lines_ + begun();
  state.acknowledged = lines_;
  state.machine = phase_ == Phase::kConnect ? "waiting for DC1" : stopped_by_control_ ? "XOFF" : "sending";
  state.uncertain = uncertain();
  state.refused = refused_;
  state.loss = loss_;
  return state;
}

}  // namespace tiltfeed::daemon
