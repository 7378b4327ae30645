#include "sim/controller/drip_controller.h"

#include <algorithm>

namespace tiltfeed::sim {
namespace {

constexpr char kDc1 = 0x11, kDc3 = 0x13, kNak = 0x15, kSyn = 0x16;

bool ends_block(char c) { return c == '\n' || c == '\r'; }

}  // namespace

DripController::DripController(const MachineModel& machine, const Setup& setup,
                               const DripControlOptions& options, Motion::Sink sink)
    : options_(options),
      motion_(machine, setup, std::max<std::size_t>(1, options.planner), std::move(sink)),
      reader_(machine.tilt.letter, machine.rotary.letter) {
  reader_.with_relative().set_position(motion_.position());
}

void DripController::receive(std::string_view bytes) {
  for (const char c : bytes) {
    if (!started_) {
      ++before_start_;
      continue;
    }
    if (alarm_ != 0) continue;
    if (stopped_) most_after_stop_ = std::max(most_after_stop_, ++after_stop_);
    if ((static_cast<unsigned char>(c) & 0x80) != 0) return raise_alarm(kAlarmFraming);
    if (buffer_.size() >= options_.buffer) return raise_alarm(kAlarmBufferOverflow);
    buffer_ += c;
    if (!stopped_ && options_.buffer - buffer_.size() <= options_.stop_free) {
      stopped_ = true;
      after_stop_ = 0;
      if (options_.says_xon_xoff) out_ += kDc3;
    }
  }
  pump();
}

/// Reads blocks out of the buffer while the planner takes them.
void DripController::pump() {
  while (alarm_ == 0) {
    while (placed_ < pending_.size()) {
      const Block& block = pending_[placed_];
      const bool waits = block.op == Op::kDwell || block.op == Op::kMCode;
      if (waits && !waiting_) {
        if (!motion_.idle()) return;
        waiting_ = true;
        motion_.push(block);
        motion_.advance(motion_.now());
      }
      if (waits && (!motion_.idle() || motion_.held())) return;
      if (!waits) {
        if (motion_.free_slots() == 0) return;
        motion_.push(block);
        motion_.advance(motion_.now());
      }
      waiting_ = false;
      ++placed_;
    }
    const auto end = std::find_if(buffer_.begin(), buffer_.end(), ends_block);
    if (end == buffer_.end()) break;
    const std::string text(buffer_.begin(), end);
    buffer_.erase(buffer_.begin(), end + 1);
    if (!take_block(text)) return raise_alarm(kAlarmFraming);
  }
  if (stopped_ && options_.buffer - buffer_.size() >= options_.go_free) {
    stopped_ = false;
    if (options_.says_xon_xoff) out_ += kDc1;
  }
}

bool DripController::take_block(std::string_view text) {
  while (!text.empty() && text.front() == '\0') {
    ++leader_;
    text.remove_prefix(1);
  }
  pending_.clear();
  placed_ = 0;
  if (text.empty()) return true;
  if (text == "%") {
    if (in_program_) ended_ = true;
    in_program_ = !in_program_;
    return true;
  }
  if (!in_program_) return true;  // noise before the program
  return static_cast<bool>(reader_.read_line(text, pending_));
}

std::string DripController::take_output() {
  std::string taken;
  taken.swap(out_);
  return taken;
}

std::optional<double> DripController::next_event() const {
  if (!started_) return options_.start_at;
  return motion_.next_event();
}

void DripController::advance(double now) {
  if (!started_ && now >= options_.start_at) {
    started_ = true;
    out_ += kDc1;
  }
  for (auto event = motion_.next_event(); event && *event <= now; event = motion_.next_event()) {
    motion_.advance(*event);
    pump();
  }
  motion_.advance(now);
}

void DripController::invite() {
  if (started_ && !in_program_ && !ended_ && buffer_.empty() && alarm_ == 0) out_ += kDc1;
}

void DripController::raise_alarm(int code) {
  alarm_ = code;
  motion_.hold();
  out_ += kNak;
}

void DripController::reset() {
  motion_.stop();
  buffer_.clear();
  pending_.clear();
  placed_ = 0;
  in_program_ = stopped_ = waiting_ = false;
  out_ += kSyn;
}

}  // namespace tiltfeed::sim
