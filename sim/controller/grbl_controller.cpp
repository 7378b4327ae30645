#include "sim/controller/grbl_controller.h"

#include <algorithm>
#include <charconv>

namespace tiltfeed::sim {
namespace {

// Error and alarm numbers of Grbl 1.1.
constexpr int kErrorSystemCommand = 3, kErrorLineLength = 11;
constexpr int kAlarmSoftLimit = 2, kAlarmResetInMotion = 3, kAlarmHomingReset = 6;

constexpr std::string_view kBanner = "\r\nGrbl 1.1h ['$' for help]\r\n";
constexpr std::string_view kUnlockHint = "[MSG:'$H'|'$X' to unlock]\r\n";

// Bytes that were used up are cut off the receive buffer in pieces of this size, not one by one.
constexpr std::size_t kCompactAt = 4096;

/// The firmware plans steps: a move without any takes no block.
MotionOptions planner_of(MotionOptions motion) {
  motion.still_takes_slot = false;
  return motion;
}

}  // namespace

GrblController::GrblController(const MachineModel& machine, const Setup& setup, const GrblOptions& options,
                               Motion::Sink sink)
    : options_(options),
      motion_(machine, setup, std::max<std::size_t>(1, options.planner), std::move(sink),
              planner_of(options.motion)),
      reader_(machine),
      offsets_(machine),
      settings_(machine),
      out_(kBanner) {
  reader_.with_relative();
  place_reader(motion_.position());
}

void GrblController::receive(std::string_view bytes) {
  for (const char c : bytes) {
    if (realtime(static_cast<unsigned char>(c))) continue;
    if (!reply_due_) {
      accept(c);
    } else if (rx_.size() - rx_read_ < options_.rx_buffer) {
      rx_.push_back(c);
    } else {
      ++totals_.dropped_bytes;
    }
  }
}

std::string GrblController::take_output() {
  std::string taken;
  taken.swap(out_);
  return taken;
}

void GrblController::greet() { out_ += kBanner; }

void GrblController::advance(double now) {
  // Event by event, so that a slot is filled again at the moment at which it became free.
  for (auto event = motion_.next_event(); event && *event <= now; event = motion_.next_event()) {
    motion_.advance(*event);
    pump();
  }
  motion_.advance(now);
}

/// One byte into the line; at its end the line is executed.
void GrblController::accept(char byte) {
  const bool second_half = byte == '\n' && after_cr_ && options_.crlf_is_one_end;
  after_cr_ = byte == '\r';
  if (second_half) return;
  if (byte == '\n' || byte == '\r') {
    execute_line();
    return;
  }
  if (line_.size() >= options_.max_line) {
    line_too_long_ = true;
  } else {
    line_.push_back(byte);
  }
}

void GrblController::execute_line() {
  const std::size_t first = line_.find_first_not_of(" \t");
  if (line_too_long_) {
    if (options_.latch_errors) latched_error_ = kErrorLineLength;
    reply_error(kErrorLineLength);
  } else if (first == std::string::npos) {
    latched_error_ = 0;
    reply_ok();
  } else if (line_[first] == '$') {
    latched_error_ = 0;
    system_command(std::string_view(line_).substr(first + 1));
  } else if (alarm_ != 0 || cycle_ != Cycle::kNone) {
    reply_error(kErrorLocked);
  } else if (latched_error_ != 0) {
    reply_error(latched_error_);
  } else {
    execute_gcode();
  }
  line_.clear();
  line_too_long_ = false;
}

void GrblController::execute_gcode() {
  pending_.clear();
  placed_ = 0;
  if (own_code()) return;
  const GrblOffsets before = offsets_;
  select_system();
  if (!reader_.read_line(line_, pending_)) {
    const Joints end = planned_end();
    offsets_ = before;
    place_reader(end);
    const int code = static_cast<int>(reader_.fault());
    if (options_.latch_errors) latched_error_ = code;
    pending_.clear();
    reply_error(code);
    return;
  }
  const GrblAxes shift = grbl_axes(offsets_.shift());
  bool ends = false;
  for (Block& block : pending_) {
    GrblAxes to = grbl_axes(block.target);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += shift[i];
    block.target = grbl_joints(to);
    ends = ends || block.m_code == 2 || block.m_code == 30;
  }
  if (ends) {  // G54 again
    const Joints end = planned_end();
    offsets_.select(0);
    place_reader(end);
  }
  for (const Block& block : pending_) {
    if (!motion_.outside(block.target)) continue;
    raise_alarm(kAlarmSoftLimit);
    return;
  }
  if (check_mode_) pending_.clear();
  reply_due_ = true;
  if (place_pending()) reply_ok();
}

/// Moves the due line's blocks on; true when the line is done.
bool GrblController::place_pending() {
  if (!follow_cycle()) return false;
  while (placed_ < pending_.size()) {
    const Block& block = pending_[placed_];
    if (synchronises(block)) {
      if (!motion_.idle()) return false;
      if (!waiting_) {
        if (motion_.held()) return false;
        waiting_ = true;
        motion_.push(block);
        motion_.advance(motion_.now());  // M codes take no time
        if (!motion_.idle()) return false;
      }
      if (motion_.held()) return false;  // M0 waits for the operator
      waiting_ = false;
    } else {
      if (motion_.free_slots() == 0) return false;
      motion_.push(block);
      motion_.advance(motion_.now());
    }
    ++placed_;
  }
  return true;
}

/// Answers the due line if it is done, then reads on.
void GrblController::pump() {
  if (cycle_ == Cycle::kJog && motion_.idle() && placed_ == pending_.size()) cycle_ = Cycle::kNone;
  if (cycle_ == Cycle::kCancel && motion_.standing()) {
    motion_.quick_stop();
    place_reader(motion_.position());
    cycle_ = Cycle::kNone;
  }
  while (true) {
    if (reply_due_) {
      if (!place_pending()) return;
      reply_ok();
    }
    if (rx_read_ == rx_.size()) break;
    accept(rx_[rx_read_++]);
    if (rx_read_ >= kCompactAt) {
      rx_.erase(0, rx_read_);
      rx_read_ = 0;
    }
  }
  rx_.clear();
  rx_read_ = 0;
}

void GrblController::system_command(std::string_view command) {
  const bool at_rest = motion_.idle() && !motion_.held();
  if (command.empty()) {
    out_ += "[HLP:$$ $I $G $C $X ~ ! ? ctrl-x]\r\n";
  } else if (command == "X" || command == "x") {
    if (reset_needed_) return reply_error(kErrorLocked);
    if (alarm_ != 0) out_ += "[MSG:Caution: Unlocked]\r\n";
    alarm_ = 0;
  } else if (command.starts_with("J=") || command.starts_with("j=")) {
    if (const int error = start_jog(command.substr(2)); error != 0) return reply_error(error);
    reply_due_ = true;
    return pump();
  } else if (command.starts_with('H') || command.starts_with('h')) {
    if (const int error = start_homing(command.substr(1)); error != 0) return reply_error(error);
    reply_due_ = true;
    return pump();
  } else if (command == "G" || command == "g") {
    report_parser();
  } else if (command == "C" || command == "c") {
    if (!at_rest || alarm_ != 0) return reply_error(kErrorNotIdle);
    check_mode_ = !check_mode_;
    out_ += check_mode_ ? "[MSG:Enabled]\r\n" : "[MSG:Disabled]\r\n";
    reply_ok();
    if (!check_mode_) reset();  // as the firmware does, to forget the checked program's modal state
    return;
  } else if (!at_rest && (command == "$" || command == "#" || command == "I" || command == "i" ||
                          command.find('=') != command.npos)) {
    return reply_error(kErrorNotIdle);
  } else if (command == "$") {
    out_ += settings_.report();
  } else if (command == "#") {
    report_parameters();
  } else if (command == "I" || command == "i") {
    report_build();
  } else {
    int number = 0;
    const char* const end = command.data() + command.size();
    const auto parsed = std::from_chars(command.data(), end, number);
    if (parsed.ec != std::errc() || parsed.ptr == end || *parsed.ptr != '=')
      return reply_error(kErrorSystemCommand);
    if (!settings_.set(number, command.substr(static_cast<std::size_t>(parsed.ptr - command.data()) + 1)))
      return reply_error(kErrorSystemCommand);
  }
  reply_ok();
}

void GrblController::reset() {
  const bool moving = motion_.running() != nullptr && !motion_.held();
  motion_.stop();
  motion_.set_feed_override(100);
  motion_.set_rapid_override(100);
  spindle_override_ = 100;
  report_overrides_ = true;
  reports_to_offset_ = 0;
  rx_.clear();
  rx_read_ = 0;
  line_.clear();
  pending_.clear();
  placed_ = 0;
  line_too_long_ = after_cr_ = reply_due_ = waiting_ = check_mode_ = reset_needed_ = false;
  latched_error_ = 0;
  offsets_.forget();
  reader_ = GcodeReader(motion_.machine());
  reader_.with_relative();
  place_reader(motion_.position());
  ++totals_.resets;
  if (moving) {
    alarm_ = cycle_ == Cycle::kHome ? kAlarmHomingReset : kAlarmResetInMotion;
    out_ += "ALARM:" + std::to_string(alarm_) + "\r\n";
  }
  cycle_ = Cycle::kNone;
  out_ += kBanner;
  if (alarm_ != 0) out_ += kUnlockHint;
}

/// The line that broke the limit gets no reply; the planner is emptied.
void GrblController::raise_alarm(int code) {
  motion_.stop();
  place_reader(motion_.position());
  cycle_ = Cycle::kNone;
  pending_.clear();
  placed_ = 0;
  rx_.clear();
  rx_read_ = 0;
  alarm_ = code;
  reset_needed_ = true;
  out_ += "ALARM:" + std::to_string(code) + "\r\n[MSG:Reset to continue]\r\n";
}

void GrblController::reply_ok() {
  reply_due_ = false;
  ++totals_.lines;
  out_ += "ok\r\n";
}

void GrblController::reply_error(int code) {
  reply_due_ = false;
  ++totals_.errors;
  out_ += "error:" + std::to_string(code) + "\r\n";
}

}  // namespace tiltfeed::sim
