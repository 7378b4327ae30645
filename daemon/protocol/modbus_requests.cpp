// What a Modbus session sends: window frames, mailbox commands, heartbeats, reads.

#include <algorithm>
#include <cassert>

#include "daemon/protocol/modbus_session.h"

namespace tiltfeed::daemon {

namespace {

/// Part of the controller's watchdog time: two lost exchanges and their time-outs fit in beside it.
constexpr double kHeartbeatShare = 0.25;
/// Blocks kept ready beside those in the controller.
constexpr std::size_t kReadyBlocks = 2 * kWindowBlocks;

}  // namespace

bool ModbusSession::wants_work() const {
  if (!skip_ || ended_ || is_final(phase_)) return false;
  if (pushed_ < known_) return true;
  return phase_ == Phase::kRun && pending_.size() - accepted_pending_ < kReadyBlocks;
}

void ModbusSession::push(NumericBlock block) {
  assert(wants_work());
  auto words =
      encode_block(block, static_cast<std::uint16_t>(pushed_ + 1), identity_, options_.map.low_word_first);
  if (!words) {
    const std::string name = quote_line(block.line, block.text);
    return fault(words.error().code, name + ": " + words.error().message);
  }
  if (++pushed_ <= known_) ++accepted_pending_;
  pass(block);
  pending_.push_back({std::move(block), *words});
}

void ModbusSession::pass(const NumericBlock& block) {
  if (++passed_ <= completed_) completed_line_ = block.line;
  if (block.op != BlockOp::kRapid && block.op != BlockOp::kFeed) return;
  const double to[] = {block.x, block.y, block.z, block.tilt, block.rotary};
  for (std::size_t i = 0; i < end_.size(); ++i) {
    if (((block.kept | block.absent) >> i & 1U) != 0) continue;
    end_[i] = to[i];
    if (block.machine) {
      end_[i].reset();  // where the machine's own place is is not known
      continue;
    }
    last_move_ = passed_;
    last_move_line_ = block.line;
  }
}

std::string_view ModbusSession::output(Time now) {
  if (is_final(phase_) || now < next_request_) return {};
  if (request_.empty()) make_request(now);
  return request_;
}

void ModbusSession::sent([[maybe_unused]] std::size_t count) {
  assert(count == request_.size() || count == 0);  // a message link takes a request whole
}

void ModbusSession::make_request(Time now) {
  ModbusRequest request;
  request_is_window_ = false;
  request_reads_status_ = step_ != Step::kIdentify && step_ != Step::kPlace;
  if (!request_reads_status_) {
    const bool place = step_ == Step::kPlace;
    request.read_address = place ? options_.map.positions : options_.map.identity;
    request.read_count = place ? kPositionsWords : kIdentityWords;
  } else {
    const bool write = step_ != Step::kLookAround && !read_only_next_;
    request_is_beat_ = false;
    if (write) request.words = next_words(now, request.write_address);
    request_reads_status_ = !write || (use_fc23_ && !request_is_beat_);
    request.read_address = request_reads_status_ ? options_.map.status : std::uint16_t{0};
    request.read_count = request_reads_status_ ? kStatusWords : std::uint16_t{0};
  }
  request_ = pack_request(request);
}

std::vector<std::uint16_t> ModbusSession::next_words(Time now, std::uint16_t& address) {
  if (step_ == Step::kStream) {
    if (!mail_.empty() && (mail_.front().code != MailboxCode::kResume || !heartbeat_due(now))) {
      address = options_.map.mailbox;
      return encode_mailbox(options_.session_id, command_seq_, mail_.front().code, mail_.front().argument,
                            options_.map.low_word_first);
    }
    // Where a frame can follow at once, the heartbeat is a short write by itself, and never two of them in
    // turn: on a line so slow that it is always due, frames and heartbeats alternate.
    const bool room = room_for_frame();
    if (room && (beat_last_ || !heartbeat_due(now))) {
      beat_last_ = false;
      address = options_.map.window;
      return window_words();
    }
    request_is_beat_ = beat_last_ = room && mail_.empty();
    address = options_.map.heartbeat;
    if (beats_) late_ = std::max(late_, now - last_heartbeat_);
    beats_ = true;
    last_heartbeat_ = now;
    return {++heartbeat_};
  }
  address = options_.map.mailbox;
  const MailboxCode code = step_ == Step::kClose ? MailboxCode::kClose : MailboxCode::kOpen;
  return encode_mailbox(options_.session_id, command_seq_, code, 0, options_.map.low_word_first);
}

bool ModbusSession::heartbeat_due(Time now) const {
  return now - last_heartbeat_ >= time_of(options_.map.watchdog * kHeartbeatShare);
}

/// It has blocks and does nothing with them: it may have dropped them, and what follows would hide that.
bool ModbusSession::idles() const {
  return completed_ < accepted() && (status_.state == RingState::kIdle || status_.state == RingState::kDone);
}

/// Whole frames, unless the program's end or a very small ring makes them shorter.
bool ModbusSession::room_for_frame() const {
  const std::size_t waiting = pending_.size() - accepted_pending_;
  if (waiting == 0 || idles()) return false;
  const std::size_t half_ring = std::max<std::size_t>(1, static_cast<std::size_t>(identity_.slots) / 2);
  return status_.free_slots >= std::min({waiting, std::size_t{kWindowBlocks}, half_ring});
}

std::vector<std::uint16_t> ModbusSession::window_words() {
  const std::size_t waiting = pending_.size() - accepted_pending_;
  frame_count_ = std::min({waiting, std::size_t{kWindowBlocks}, std::size_t{status_.free_slots}});
  std::array<std::array<std::uint16_t, kBlockWords>, kWindowBlocks> blocks;
  for (std::size_t k = 0; k < frame_count_; ++k) blocks[k] = pending_[accepted_pending_ + k].words;
  touched_ = std::max(touched_, accepted() + frame_count_);
  request_is_window_ = true;
  return encode_window(options_.session_id, std::span(blocks).first(frame_count_),
                       ended_ && frame_count_ == waiting, options_.map.low_word_first);
}

}  // namespace tiltfeed::daemon
