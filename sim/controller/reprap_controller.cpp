#include "sim/controller/reprap_controller.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace tiltfeed::sim {
namespace {

constexpr double kBusyEvery = 2.0;  // s
constexpr std::string_view kStart = "start\necho:Marlin bugfix-2.1.x\n";
constexpr std::string_view kIdentity =
    "FIRMWARE_NAME:Marlin bugfix-2.1.x SOURCE_CODE_URL:example PROTOCOL_VERSION:1.0 MACHINE_TYPE:AC5\n"
    "Cap:SERIAL_XON_XOFF:0\nCap:AUTOREPORT_POS:1\n";

constexpr std::size_t kNative = 9;  // no work system is in force
constexpr std::array kSystems = {"G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"};

/// The whole number after a letter, or nothing.
std::optional<std::uint64_t> number_after(std::string_view text, std::size_t at) {
  std::uint64_t value = 0;
  std::size_t digits = 0;
  for (; at < text.size() && text[at] >= '0' && text[at] <= '9' && digits < 12; ++at, ++digits)
    value = value * 10 + static_cast<std::uint64_t>(text[at] - '0');
  if (digits == 0) return std::nullopt;
  return value;
}

}  // namespace

RepRapController::RepRapController(const MachineModel& machine, const Setup& setup,
                                   const RepRapOptions& options, Motion::Sink sink)
    : options_(options),
      motion_(machine, setup, std::max<std::size_t>(1, options.planner), std::move(sink),
              {.still_takes_slot = false}),
      reader_(machine.tilt.letter, machine.rotary.letter),
      out_(kStart) {
  reader_.with_relative();
  place_reader(motion_.position());
}

void RepRapController::receive(std::string_view bytes) {
  for (const char c : bytes) {
    if (c == '\n' || c == '\r') {
      if (options_.emergency_parser && emergency(live_)) {
        live_.clear();
        rx_.erase(rx_.rfind('\n') == rx_.npos ? 0 : rx_.rfind('\n') + 1);
        continue;
      }
      live_.clear();
    } else if (live_.size() < options_.max_line) {
      live_ += c;
    }
    if (rx_.size() < options_.rx_buffer) {
      rx_ += c;
    } else {
      ++totals_.dropped_bytes;
    }
    read_lines();
  }
  pump();
}

/// Commands that act although the queue is full.
bool RepRapController::emergency(std::string_view line) {
  if (line == "M108") {
    paused_ = false;
    motion_.resume();
    return true;
  }
  if (line == "M112") return halt(), true;
  if (line != "M410") return false;
  motion_.quick_stop();
  motion_.resume();
  place_reader(motion_.position());
  pending_.clear();
  placed_ = 0;
  return true;
}

void RepRapController::read_lines() {
  while (!rx_.empty() && queue_.size() < options_.queue && !halted_) {
    const char c = rx_.front();
    rx_.erase(0, 1);
    if (c != '\n' && c != '\r') {
      if (line_.size() < options_.max_line) line_ += c;
      continue;
    }
    std::string line;
    line.swap(line_);
    if (!line.empty()) take_line(std::move(line));
  }
}

void RepRapController::take_line(std::string text) {
  if (const std::size_t comment = text.find(';'); comment != text.npos) text.resize(comment);
  const std::size_t star = text.rfind('*');
  Command command;
  if (text.starts_with('N')) {
    const auto number = number_after(text, 1);
    const bool sets_number = text.find("M110") != text.npos;
    if (star == text.npos) return refuse("No Checksum with line number");
    unsigned char sum = 0;
    for (std::size_t i = 0; i < star; ++i)
      sum = static_cast<unsigned char>(sum ^ static_cast<unsigned char>(text[i]));
    const auto given = number_after(text, star + 1);
    if (!given || *given != sum) return refuse("checksum mismatch");
    if (!number || (*number != last_number_ + 1 && !sets_number))
      return refuse("Line Number is not Last Line Number+1");
    last_number_ = command.number = *number;
    text.resize(star);
    text.erase(0, text.find_first_not_of("0123456789", 1));
  } else if (star != text.npos) {
    return refuse("No Line Number with checksum");
  }
  command.text = text.substr(std::min(text.find_first_not_of(' '), text.size()));
  if (!command.text.empty()) queue_.push_back(std::move(command));
}

void RepRapController::refuse(const std::string& what) {
  ++totals_.resends;
  rx_.clear();
  line_.clear();
  out_ += "Error:" + what + ", Last Line: " + std::to_string(last_number_) + "\n";
  out_ += "Resend: " + std::to_string(last_number_ + 1) + "\n";
  if (options_.resend_ok) out_ += "ok\n";
}

std::string RepRapController::take_output() {
  std::string taken;
  taken.swap(out_);
  return taken;
}

std::optional<double> RepRapController::next_event() const {
  const std::optional<double> event = motion_.next_event();
  if (queue_.empty() || halted_) return event;
  return event ? std::min(*event, busy_at_) : busy_at_;
}

void RepRapController::advance(double now) {
  for (auto event = next_event(); event && *event <= now; event = next_event()) {
    motion_.advance(std::max(*event, motion_.now()));
    pump();
    if (!queue_.empty() && !halted_ && motion_.now() >= busy_at_) {
      out_ += paused_ ? "echo:busy: paused for user\n" : "echo:busy: processing\n";
      busy_at_ = motion_.now() + kBusyEvery;
    }
  }
  motion_.advance(now);
}

void RepRapController::pump() {
  while (!queue_.empty() && !halted_) {
    if (!started_) busy_at_ = motion_.now() + kBusyEvery;
    if (!run(queue_.front())) return;
    started_ = false;
    reply_ok(queue_.front());
    queue_.pop_front();
    read_lines();
  }
}

/// True when the command is done.
bool RepRapController::run(const Command& command) {
  const std::string& text = command.text;
  if (!started_) {
    started_ = true;
    pending_.clear();
    placed_ = 0;
    if (!run_own(text) && !reader_.read_line(text, pending_)) {
      out_ += "echo:Unknown command: \"" + text + "\"\n";
      pending_.clear();
    }
    const bool moves =
        std::any_of(pending_.begin(), pending_.end(), [](const Block& b) { return !synchronises(b); });
    if (stopped_ && moves) {
      out_ += "Printer stopped due to errors. Fix the error and use M999 to restart.\n";
      pending_.clear();
      place_reader(motion_.position());
    }
    for (Block& block : pending_) block.target = shifted(block.target, 1.0);
    for (const Block& block : pending_)
      if (motion_.outside(block.target)) return halt(), false;
  }
  if (text.starts_with("M400")) return motion_.idle();
  return place();
}

/// Program coordinates to those of the simulated axes (+1) and back (-1).
Joints RepRapController::shifted(const Joints& at, double sign) const {
  const Joints& offset = offsets_[system_];
  return {at.x + sign * offset.x, at.y + sign * offset.y, at.z + sign * offset.z, at.a + sign * offset.a,
          at.c + sign * offset.c};
}

/// What no program says: the firmware's own words. False: it is for the reader.
bool RepRapController::run_own(const std::string& text) {
  const std::string code = text.substr(0, text.find_first_not_of("0123456789.", 1));
  if (code == "M110" || code == "M400" || code == "M108") return true;
  if (code == "M114") return report_place(), true;
  if (code == "M115") {
    out_ += kIdentity;
    out_ += options_.emergency_parser ? "Cap:EMERGENCY_PARSER:1\n" : "Cap:EMERGENCY_PARSER:0\n";
    return true;
  }
  if (code == "M220") {
    const std::size_t at = text.find('S');
    if (at == text.npos) return out_ += "FR:" + std::to_string(motion_.feed_override()) + "%\n", true;
    motion_.set_feed_override(
        static_cast<int>(std::clamp<std::uint64_t>(number_after(text, at + 1).value_or(100), 10, 999)));
    return true;
  }
  if (code == "M999") return stopped_ = false, true;
  if (code == "M500") return out_ += "echo:Settings Stored (300 bytes; crc 1234)\n", true;
  if (code == "M503") return report_settings(), true;
  if (const auto setting = settings_.find(code); setting != settings_.end()) {
    if (text.size() > code.size() + 1) setting->second = text.substr(code.size() + 1);
    return true;
  }
  if (code == "G28") return home(text), true;
  if (code == "G92") return set_offset(text), true;
  const auto system = std::find(kSystems.begin(), kSystems.end(), code);
  if (system == kSystems.end()) return false;
  if (!options_.work_systems) return out_ += "echo:Unknown command: \"" + text + "\"\n", true;
  const Joints stands = shifted(reader_.modal().at, 1.0);
  system_ = static_cast<std::size_t>(system - kSystems.begin());
  place_reader(stands);
  return true;
}

/// The axes stand there, as the offset in force calls it.
void RepRapController::place_reader(const Joints& stands) {
  reader_.set_position(shifted(stands, -1.0));
  reader_.set_top(motion_.machine().z.max - offsets_[system_].z);
}

/// The named axes, or all, to 0 of the simulated axes.
void RepRapController::home(const std::string& text) {
  const std::string_view words = std::string_view(text).substr(3);
  const bool all = words.find_first_not_of(' ') == words.npos;
  const auto named = [&](char letter) { return all || words.find(letter) != words.npos; };
  const MachineModel& machine = motion_.machine();
  Joints to = shifted(reader_.modal().at, 1.0);
  if (named('X')) to.x = 0.0;
  if (named('Y')) to.y = 0.0;
  if (named('Z')) to.z = 0.0;
  if (named(machine.tilt.letter)) to.a = 0.0;
  if (named(machine.rotary.letter)) to.c = 0.0;
  Block move;
  move.op = Op::kRapid;
  move.target = shifted(to, -1.0);
  pending_.push_back(move);
  reader_.set_position(move.target);
}

/// G92: the named axes are called so from here on.
void RepRapController::set_offset(const std::string& text) {
  Joints at = reader_.modal().at;
  const Joints stands = shifted(at, 1.0);
  const MachineModel& machine = motion_.machine();
  const std::pair<char, double Joints::*> axes[] = {{'X', &Joints::x},
                                                    {'Y', &Joints::y},
                                                    {'Z', &Joints::z},
                                                    {machine.tilt.letter, &Joints::a},
                                                    {machine.rotary.letter, &Joints::c}};
  for (const auto& [letter, member] : axes) {
    const std::size_t word = text.find(letter, 3);
    if (word == text.npos) continue;
    at.*member = std::strtod(text.c_str() + word + 1, nullptr);
    offsets_[system_].*member = stands.*member - at.*member;
  }
  place_reader(stands);
}

void RepRapController::report_settings() {
  out_ += "echo:  G21    ; Units in mm (mm)\n";
  for (const auto& [code, words] : settings_) out_ += "echo:  " + code + " " + words + "\n";
}

/// Two decimals, as the firmware prints them: where the commands lead that it has taken.
void RepRapController::report_place() {
  const Joints& at = reader_.modal().at;
  const MachineModel& machine = motion_.machine();
  const std::pair<char, double> axes[] = {
      {'X', at.x}, {'Y', at.y}, {'Z', at.z}, {machine.tilt.letter, at.a}, {machine.rotary.letter, at.c}};
  for (const auto& [letter, value] : axes) {
    char text[340];
    std::snprintf(text, sizeof text, "%c:%.2f ", letter, value);
    out_ += text;
  }
  out_ += "E:0.00 Count X:0 Y:0 Z:0\n";
}

bool RepRapController::place() {
  while (placed_ < pending_.size()) {
    const Block& block = pending_[placed_];
    if (synchronises(block)) {
      if (!waiting_) {
        if (!motion_.idle()) return false;
        waiting_ = true;
        motion_.push(block);
        motion_.advance(motion_.now());
        if (motion_.held()) paused_ = true;  // M0, M1
      }
      if (!motion_.idle() || motion_.held()) return false;
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

void RepRapController::reply_ok(const Command& command) {
  ++totals_.lines;
  out_ += "ok";
  if (options_.advanced_ok) {
    if (command.number > 0) out_ += " N" + std::to_string(command.number);
    out_ +=
        " P" + std::to_string(motion_.free_slots()) + " B" + std::to_string(options_.queue - queue_.size());
  }
  out_ += '\n';
}

void RepRapController::reset() {
  motion_.stop();
  motion_.resume();
  motion_.set_feed_override(100);
  reader_ = GcodeReader(motion_.machine().tilt.letter, motion_.machine().rotary.letter);
  reader_.with_relative();
  rx_.clear();
  line_.clear();
  live_.clear();
  queue_.clear();
  pending_.clear();
  placed_ = 0;
  started_ = waiting_ = paused_ = halted_ = stopped_ = false;
  offsets_ = {};
  system_ = kNative;
  place_reader(motion_.position());
  last_number_ = 0;
  ++totals_.resets;
  out_ = kStart;
}

void RepRapController::halt() {
  motion_.stop();
  queue_.clear();
  pending_.clear();
  placed_ = 0;
  started_ = waiting_ = false;
  halted_ = true;
  out_ += "Error:Printer halted. kill() called!\n";
}

}  // namespace tiltfeed::sim
