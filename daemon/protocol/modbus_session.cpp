#include "daemon/protocol/modbus_session.h"

#include <algorithm>
#include <cassert>

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kDrainPoll = milliseconds(20);
constexpr Time kHoldPoll = milliseconds(100);
/// Exceptions "busy" and "acknowledge": the controller asks for time.
constexpr Time kBusyPause = milliseconds(50);
/// No usable reply for so long: the link is gone.
constexpr Time kLinkLoss = seconds(10);
/// Idle although blocks are in the ring: a cycle or two is normal between blocks.
constexpr Time kIdleStall = seconds(10);
/// Frames refused, or status words unusable, one after the other: chance is excluded.
constexpr int kMaxRefusals = 10, kMaxRereads = 20;
/// Exception 4 at the program's end: a reading that failed may succeed.
constexpr int kMostPlaceFailures = 3;

}  // namespace

ModbusSession::ModbusSession(const ModbusOptions& options, Time now)
    : options_(options), next_request_(now), last_reply_(now), last_progress_(now), step_began_(now) {
  assert(options.session_id != 0);
  if (!options.attach) skip_ = 0;
}

void ModbusSession::move(Event event) {
  const std::optional<Phase> next = next_phase(phase_, event);
  assert(next);
  phase_ = *next;
}

void ModbusSession::receive(std::string_view bytes, Time now) {
  if (bytes.empty() || request_.empty() || is_final(phase_)) return;
  on_reply(unpack_reply(bytes), now);
}

void ModbusSession::on_reply(const ModbusReply& reply, Time now) {
  next_request_ = now;
  if (reply.outcome == kReplyMissing) return on_missing(now);
  if (reply.outcome != kReplyOk) return on_exception(reply.outcome, now);
  last_reply_ = now;
  request_.clear();
  judge_window_ = judge_window_ || request_is_window_;
  if (step_ == Step::kIdentify) return on_identity(reply.words, now);
  if (step_ == Step::kPlace) return on_place(reply.words, now);
  read_only_next_ = !request_reads_status_ && !request_is_beat_;
  if (!request_reads_status_) return;
  if (reply.words.size() != kStatusWords) return fault(Code::kLink, "a status reply has the wrong length");
  on_status(parse_ring_status(reply.words, options_.map.low_word_first), now);
}

/// The request stays as it is: the same bytes go out again.
void ModbusSession::on_missing(Time now) {
  ++resends_;
  if (now - last_reply_ >= kLinkLoss)
    lose(Loss::kWire, "no reply from the controller for 10 s; check the cable and the unit number");
}

void ModbusSession::on_exception(std::uint8_t exception, Time now) {
  const std::string name = "Modbus exception " + std::to_string(exception);
  if (step_ == Step::kPlace && exception == 4 && ++place_failures_ <= kMostPlaceFailures) {
    next_request_ = now + kBusyPause;
    return;
  }
  const bool no_place = step_ == Step::kPlace && exception <= 3;
  if (no_place) step_ = Step::kClose, request_.clear();
  if (no_place) return;
  switch (exception) {
    case 1:  // illegal function
      if (use_fc23_ && request_reads_status_ && step_ >= Step::kOpen && !read_only_next_) {
        use_fc23_ = false;
        request_.clear();
        return;
      }
      return fault(Code::kLink, name + ": the controller knows neither FC23 nor FC16 and FC3");
    case 5:
    case 6:
    case 10:
    case 11:
      next_request_ = now + kBusyPause;
      if (now - last_reply_ >= kLinkLoss) lose(Loss::kWire, name + " for 10 s: the controller stays busy");
      return;
    default:
      return fault(Code::kLink, name + ": the controller's register map is another one, or it is defective");
  }
}

/// What was read cannot be used; nothing is concluded from it.
void ModbusSession::read_again(const char* why, Time now) {
  if (++rereads_ > kMaxRereads)
    return fault(Code::kLink, std::string("the controller's status stays unusable: ") + why);
  read_only_next_ = true;
  next_request_ = now;
}

void ModbusSession::on_status(const RingStatus& status, Time now) {
  if (status.torn) return read_again("torn (its first and last word differ)", now);
  if (last_status_seq_ == status.status_seq) return read_again("old (its sequence number stands still)", now);
  last_status_seq_ = status.status_seq;
  if (status.boot_id != identity_.boot_id && aborting_) {
    loss_ = Loss::kRestarted;
    return fault(Code::kCancelled, "aborted on request: the controller was reset in motion, home it first");
  }
  if (status.boot_id != identity_.boot_id)
    return lose(Loss::kRestarted, "the controller has restarted (its start number, boot_id, was " +
                                      std::to_string(identity_.boot_id) + " and is " +
                                      std::to_string(status.boot_id) +
                                      "); nothing is sent again: home the machine first");
  switch (step_) {
    case Step::kIdentify:
    case Step::kPlace:
      return;
    case Step::kLookAround:
      look_around(status, now);
      break;
    case Step::kOpen:
    case Step::kClose:
      on_command_status(status, now);
      break;
    case Step::kStream:
      on_stream_status(status, now);
      break;
  }
}

void ModbusSession::on_stream_status(const RingStatus& status, Time now) {
  if (phase_ == Phase::kStop && !mail_.empty() && mail_.front().code == MailboxCode::kClose &&
      status.command_ack == command_seq_) {
    // A session that is refused its end for the blocks in it has not obeyed the stop either.
    if (status.command_result == 0 || status.state == RingState::kNoSession) return finish_stop();
    return fault(Code::kLink,
                 "the controller refuses the stop: it still has the session and its blocks; "
                 "`tiltfeed reset` ends that");
  }
  if (status.state == RingState::kNoSession)
    return lose(Loss::kForgotten, "the controller has dropped the session");
  if (status.session != options_.session_id) return read_again("of another session", now);
  if (!advance(status, now)) return;
  rereads_ = 0;
  if (status.state == RingState::kAlarm)
    return fault(
        Code::kLink,
        "the machine is in alarm " + std::to_string(status.alarm) + " at " + block_name(status.last_started),
        Event::kAlarm);
  follow_mail(status, now);
  follow_hold(status, now);
  if (is_final(phase_)) return;
  if (judge_window_) judge_frame(status);
  if (phase_ == Phase::kFault) return;
  if (ended_ && accepted() == pushed_ && phase_ == Phase::kRun) move(Event::kAllSent);
  if (phase_ == Phase::kDrain && completed_ == pushed_ && mail_.empty()) {
    step_ = place_is_out() ? Step::kPlace : Step::kClose;
    step_began_ = now;
    return;
  }
  if (!mail_.empty()) {
    next_request_ = now + kFullRingPoll;
    return;
  }
  if (idles() && now - last_progress_ >= kIdleStall)
    return fault(Code::kLink,
                 "the machine stands idle although blocks wait in its ring, or it has dropped them");
  if (room_for_frame() || wants_work()) return;
  next_request_ = now + kFullRingPoll;
  if (phase_ == Phase::kDrain) next_request_ = now + kDrainPoll;
  if (status.state == RingState::kHold) next_request_ = now + kHoldPoll;
}

/// Takes over last_accepted and last_completed; false when they cannot be true.
bool ModbusSession::advance(const RingStatus& status, Time now) {
  const int more_accepted = ring_ahead(status.last_accepted, ring_sequence(accepted()));
  const int more_completed = ring_ahead(status.last_completed, ring_sequence(completed_));
  if (more_accepted < 0 || more_completed < 0) {
    read_again("older than what was read before", now);
    return false;
  }
  if (accepted() + static_cast<unsigned>(more_accepted) > touched_ ||
      static_cast<unsigned>(more_completed) > accepted_pending_ + static_cast<unsigned>(more_accepted)) {
    fault(Code::kLink, "the controller claims blocks that were never sent");
    return false;
  }
  // What this request may have brought is taken already; had it come in time, some of the rest would be left.
  ran_out_ = accepted() > 0 && static_cast<unsigned>(more_completed) >= accepted_pending_;
  if (more_accepted > 0 || more_completed > 0 || status.state != status_.state) last_progress_ = now;
  accepted_pending_ += static_cast<unsigned>(more_accepted);
  frame_count_ -= std::min<std::size_t>(frame_count_, static_cast<unsigned>(more_accepted));
  if (more_accepted > 0) refusals_ = 0;
  for (int i = 0; i < more_completed; ++i) {
    waits_at_ =
        is_operator_stop(pending_.front().block) ? std::optional(pending_.front().words[0]) : std::nullopt;
    completed_line_ = pending_.front().block.line;
    pending_.pop_front();
  }
  accepted_pending_ -= static_cast<unsigned>(more_completed);
  completed_ += static_cast<unsigned>(more_completed);
  status_ = status;
  return true;
}

/// A frame was written and this status is newer: was it taken, and if not, why?
void ModbusSession::judge_frame(const RingStatus& status) {
  judge_window_ = false;
  if (frame_count_ == 0) return;
  if (status.nack == Nack::kSession)
    return lose(Loss::kForgotten, "the controller no longer knows this session");
  const int place = ring_ahead(status.nack_seq, ring_sequence(accepted()));
  if (status.nack == Nack::kBadBlock && place >= 1 && place <= static_cast<int>(frame_count_))
    return fault(Code::kLink, "the controller refuses " + block_name(status.nack_seq) + " as a bad block");
  if (status.free_slots == 0) return;  // full: the rest goes out again when there is room
  if (status.nack != Nack::kNone) ++resends_;
  if (++refusals_ > kMaxRefusals)
    fault(Code::kLink, "the controller has refused the same frame " + std::to_string(kMaxRefusals) +
                           " times (nack " + std::to_string(static_cast<int>(status.nack)) + "), from " +
                           block_name(ring_sequence(accepted() + 1)));
}

void ModbusSession::link_lost(const Error& error) {
  if (is_final(phase_)) return;
  loss_ = Loss::kWire;
  fault(error.code, error.message);
}

// ---- reports -------------------------------------------------------------------------------------------

std::string ModbusSession::block_name(std::uint16_t seq) const {
  const int place = ring_ahead(seq, ring_sequence(completed_));
  if (place < 1 || place > static_cast<int>(pending_.size()))
    return "block " + std::to_string(seq) + " (completed before)";
  const NumericBlock& block = pending_[static_cast<std::size_t>(place - 1)].block;
  return quote_line(block.line, block.text);
}

/// The program's last move is counted as completed, and where the axes are was not read yet.
bool ModbusSession::place_is_out() const {
  const bool known = std::any_of(end_.begin(), end_.end(), [](const auto& axis) { return axis.has_value(); });
  const bool at_end = ended_ || options_.before + pushed_ == options_.total;
  return identity_.positions && known && at_end && completed_ >= last_move_ && step_ < Step::kClose;
}

/// Completed blocks, but for those that the axes' place at the end must prove.
std::uint64_t ModbusSession::proved() const {
  if (!identity_.positions || step_ == Step::kClose) return completed_;
  // Not read from the program yet: the last move may be among them.
  if (passed_ < completed_) return std::min(options_.executed, completed_);
  return place_is_out() ? last_move_ - 1 : completed_;
}

LineRange ModbusSession::uncertain() const {
  LineRange lines;
  if (touched_ != completed_ && !pending_.empty()) {
    const std::size_t last = std::min<std::uint64_t>(touched_ - completed_, pending_.size()) - 1;
    lines = {pending_.front().block.line, pending_[last].block.line};
  }
  if (place_is_out()) lines = {last_move_line_, std::max(lines.last, completed_line_)};
  return lines;
}

void ModbusSession::fault(Code code, const std::string& what, Event event) {
  // Everything was proved before; only the session's end was still out.
  if (step_ == Step::kClose) return move(Event::kProved);
  error_ = {code, what};
  if (place_is_out() && completed_ == pushed_)
    error_.message = "every block is counted as executed, but " +
                     (elsewhere_ ? "" : std::string("the axes were not read at the program's end: ")) + what;
  if (!is_opening(phase_)) error_.message += "; " + describe(state());
  move(event);
  request_.clear();
}

void ModbusSession::lose(Loss loss, const std::string& what) {
  loss_ = loss;
  fault(Code::kLink, what);
}

SendState ModbusSession::state() const {
  SendState state;
  state.phase = phase_;
  state.total = options_.total;
  state.sent = options_.before + touched_;
  state.acknowledged = options_.before + std::max(accepted(), known_);
  state.executed = options_.before + proved();
  state.elsewhere = elsewhere_;
  if (phase_ == Phase::kRun) state.starved = ran_out_ && state.acknowledged < options_.total;
  state.held = held_;
  state.resends = resends_;
  if (last_status_seq_) state.machine = ring_state_name(status_.state);
  state.line = status_.line;
  if (phase_ != Phase::kDone) state.uncertain = uncertain();
  state.loss = loss_;
  state.provable = true;
  state.session = options_.session_id;
  state.boot = identity_.boot_id;
  state.feed_override = status_.feed_override;
  state.refused = refused_;
  return state;
}

}  // namespace tiltfeed::daemon
