#include "daemon/protocol/drive_session.h"

#include <cassert>
#include <utility>

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kPoll = milliseconds(5), kAgain = milliseconds(50);
/// So long may what may be repeated stay without an answer.
constexpr Time kAnswerTimeout = seconds(10);
/// In a move no longer: three readings without an answer.
constexpr Time kSilentInMove = seconds(1);
/// No axis brakes longer.
constexpr Time kBrakes = seconds(10);
constexpr std::size_t kBlocksAhead = 2;
constexpr std::uint8_t kAcknowledged = 5, kBusy = 6;  // Modbus exceptions

}  // namespace

DriveSession::DriveSession(const DriveOptions& options, Time now)
    : options_(options), encoder_(options.map), next_(now), heard_(now) {}

void DriveSession::move(Event event) {
  const std::optional<Phase> next = next_phase(phase_, event);
  assert(next);
  phase_ = *next;
}

bool DriveSession::wants_work() const {
  return phase_ == Phase::kRun && !ended_ && pending_.size() < kBlocksAhead;
}

void DriveSession::push(NumericBlock block) {
  assert(wants_work());
  auto words = encoder_.encode(block);
  if (!words) return fault(quote_line(block.line, block.text) + ": " + words.error().message);
  pending_.push_back({std::move(block), std::move(*words)});
}

/// The next thing to do once the block before is done.
void DriveSession::choose(Time now) {
  next_ = heard_ = now;
  if (phase_ != Phase::kRun) return;
  if (pending_.empty()) {
    if (!ended_) return;
    move(Event::kAllSent);
    return move(Event::kProved);
  }
  const Pending& front = pending_.front();
  if (!front.words.empty()) {
    step_ = Step::kWrite;
  } else if (front.block.op == BlockOp::kDwell) {
    step_ = Step::kDwell;
    next_ = now + time_of(front.block.seconds);
  } else if (is_operator_stop(front.block)) {
    step_ = Step::kOperator;
    next_ = now + kAgain;
    move(Event::kOperatorStop);
  } else {
    complete();
  }
}

void DriveSession::complete() {
  pending_.pop_front();
  ++completed_;
  written_ = answered_ = false;
  step_ = Step::kChoose;
}

std::string_view DriveSession::output(Time now) {
  if (is_final(phase_)) return request_;  // after a fault: the stop
  if (now < next_) return {};
  if (step_ == Step::kDwell) complete();
  for (std::uint64_t before = completed_ + 1; step_ == Step::kChoose && before != completed_;) {
    before = completed_;
    choose(now);
  }
  if (!request_.empty() || is_final(phase_)) return request_;
  const config::DriveMap& map = options_.map;
  switch (step_) {
    case Step::kLook:
    case Step::kWatch:
    case Step::kStand:
      request_ = pack_request({0, map.status, 1, {}});
      break;
    case Step::kWrite:
      request_ = pack_request({map.block, 0, 0, pending_.front().words});
      break;
    case Step::kStop:
      request_ = stop_request();
      break;
    case Step::kChoose:
    case Step::kDwell:
    case Step::kOperator:
    case Step::kHeld:
      next_ = std::max(next_, now + kPoll);
      break;
  }
  return request_;
}

void DriveSession::sent([[maybe_unused]] std::size_t count) {
  if (step_ == Step::kWrite && count > 0) written_ = true;
}

void DriveSession::receive(std::string_view bytes, Time now) {
  if (bytes.empty() || request_.empty() || is_final(phase_)) return;
  const ModbusReply reply = unpack_reply(bytes);
  request_.clear();
  next_ = now;
  if (reply.outcome == kReplyMissing) return on_missing(now);
  if (reply.outcome != kReplyOk) {
    const bool busy = reply.outcome == kAcknowledged || reply.outcome == kBusy;
    if (busy && step_ != Step::kWrite) return on_missing(now);
    return fault("the drive answers Modbus exception " + std::to_string(reply.outcome) + " to " +
                 (step_ == Step::kWrite ? quote_line(pending_.front().block.line, pending_.front().block.text)
                                        : std::string(step_ == Step::kStop ? "its stop" : "its status") +
                                              ": the profile's wire.drive is not this drive's"));
  }
  heard_ = now;
  if (step_ == Step::kWrite || step_ == Step::kStop) {
    answered_ = answered_ || step_ == Step::kWrite;
    step_ = step_ == Step::kWrite ? Step::kWatch : Step::kStand;
    next_ = now + time_of(options_.map.settle);
  } else if (reply.words.size() != 1) {
    fault("a status reply has the wrong length");
  } else {
    on_status(reply.words.front(), now);
  }
}

void DriveSession::on_status(std::uint16_t status, Time now) {
  const config::DriveMap& map = options_.map;
  if ((status & map.fault_mask) != 0)
    return fault("the drive is in alarm (status " + std::to_string(status) + ")" +
                     (step_ == Step::kLook ? "; clear it first: nothing was sent" : ""),
                 Event::kAlarm);
  const bool moving = (status & map.moving_mask) == map.moving_value;
  if (step_ == Step::kLook) {
    if (moving) return fault("the drive is moving; end that first: nothing was sent");
    move(Event::kAnswered);
    move(Event::kReady);
    step_ = Step::kChoose;
  } else if (moving) {
    next_ = now + kPoll;
    if (phase_ == Phase::kStop && now - stop_asked_ >= kBrakes)
      fault("the drive took its stop and still says after " + std::to_string(kBrakes / seconds(1)) +
            " s that it moves (status " + std::to_string(status) + "): stop it at its own panel");
  } else if (step_ == Step::kWatch) {
    complete();
  } else if (phase_ == Phase::kStop) {
    error_ = {Code::kCancelled, "stopped on request; " + range_text()};
    move(Event::kStood);
  } else {
    step_ = Step::kHeld;
    if (resume_asked_) go_on();
  }
}

/// A move is never written again: it may have been done. Reading and stopping may be repeated.
void DriveSession::on_missing(Time now) {
  if (step_ == Step::kWrite) {
    loss_ = Loss::kWire;
    return fault("no answer to the write of " +
                 quote_line(pending_.front().block.line, pending_.front().block.text) +
                 ": the drive may have moved; nothing is sent again");
  }
  next_ = now + kAgain;
  // One that was switched off in a move stands when it is back, and not where it was sent.
  const bool moves = step_ == Step::kWatch;
  if (now - heard_ < (moves ? kSilentInMove : kAnswerTimeout)) return;
  loss_ = Loss::kWire;
  fault(moves
            ? "the drive has not answered for 1 s in a move: it may have been switched off, and its zero lost"
            : "the drive has not answered for 10 s");
}

void DriveSession::command(const OperatorCommand& command, Time now) {
  const Answer answer = answer_to(command.order, phase_);
  refused_ = refusal_text(answer);
  if (command.order == Order::kHold || command.order == Order::kStop) resume_asked_ = false;
  if (answer == Answer::kEnd) {
    error_ = {Code::kCancelled, "stopped on request; nothing has moved"};
    return move(Event::kStood);
  }
  if (answer != Answer::kObey) return;
  switch (command.order) {
    case Order::kHold:
      return ask_stop(Event::kHeld, now);
    case Order::kStop:
      return ask_stop(Event::kStopAsked, now);
    case Order::kAbort:
      loss_ = Loss::kForgotten;
      return fault("aborted on request");
    case Order::kResume:
      if (phase_ == Phase::kToolChange) {
        move(Event::kOperatorDone);
        return complete();
      }
      resume_asked_ = true;
      if (step_ == Step::kHeld) go_on();
      return;
    default:
      refused_ = "no overrides over this link";
  }
}

/// What the hold cut short goes out again: its end is an absolute place.
void DriveSession::go_on() {
  resume_asked_ = false;
  move(Event::kResumed);
  step_ = Step::kChoose;
}

void DriveSession::ask_stop(Event event, Time now) {
  move(event);
  step_ = Step::kStop;
  request_.clear();
  next_ = heard_ = stop_asked_ = now;
}

std::string DriveSession::stop_request() const {
  return pack_request({options_.map.stop, 0, 0, {static_cast<std::uint16_t>(options_.map.stop_value)}});
}

void DriveSession::link_lost(const Error& error) {
  if (is_final(phase_)) return;
  loss_ = Loss::kWire;
  fault(error.message);
}

void DriveSession::fault(const std::string& what, Event event) {
  const bool opening = is_opening(phase_);
  error_ = {Code::kLink, opening ? what : what + "; " + range_text()};
  move(event);
  request_ = opening ? std::string() : stop_request();
}

std::string DriveSession::range_text() const {
  return describe(state()) +
         (completed_ == 0 ? "" : "; what has run is the drive's word: it numbers no moves");
}

/// The block in work; all before it are done as far as the drive's word goes.
LineRange DriveSession::uncertain() const {
  if (!written_) return {};
  return {pending_.front().block.line, pending_.front().block.line};
}

SendState DriveSession::state() const {
  SendState state;
  state.phase = phase_;
  state.total = options_.total;
  state.sent = completed_ + written_;
  state.acknowledged = completed_ + answered_;
  state.executed = completed_;
  state.machine = step_ == Step::kLook     ? ""  // it has not said anything yet
                  : phase_ == Phase::kHold ? (step_ == Step::kHeld ? "Hold" : "Stopping")
                  : written_               ? "Run"
                                           : "Idle";
  if (phase_ != Phase::kDone) state.uncertain = uncertain();
  state.loss = loss_;
  state.refused = refused_;
  return state;
}

}  // namespace tiltfeed::daemon
