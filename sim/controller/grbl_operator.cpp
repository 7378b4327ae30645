// What an operator asks the Grbl firmware model for beside programs: jogs, homing, probing, work offsets.

#include <algorithm>
#include <cmath>

#include "sim/controller/grbl_controller.h"

namespace tiltfeed::sim {
namespace {

// Error and alarm numbers of Grbl 1.1 and grblHAL.
constexpr int kErrorHomingOff = 5, kErrorTravel = 15, kErrorJogWord = 16, kErrorUnsupported = 20,
              kErrorNoFeed = 22, kErrorNotInteger = 23, kErrorNoAxes = 26, kErrorMissingWord = 28,
              kErrorNoSystem = 29;
constexpr int kAlarmProbeTouches = 4, kAlarmNoContact = 5, kAlarmHomingFailed = 9;
constexpr int kSoftLimits = 20, kHoming = 22, kHomingDirection = 23, kPullOff = 27;
constexpr double kInch = 25.4;

int tenths(double value) { return static_cast<int>(std::lround(value * 10.0)); }

bool has(const GrblWords& words, int code) {
  return std::any_of(words.begin(), words.end(),
                     [&](const auto& word) { return word.first == 'G' && tenths(word.second) == code; });
}

std::optional<double> word(const GrblWords& words, char letter) {
  for (const auto& [is, value] : words)
    if (is == letter) return value;
  return std::nullopt;
}

/// Most lines of a program have no such code, and this says so at once.
bool may_have_own_code(std::string_view line) {
  for (std::size_t i = 0; i + 2 < line.size(); ++i) {
    if (line[i] != 'G' && line[i] != 'g') continue;
    const char a = line[i + 1], b = line[i + 2];
    if ((a == '1' && b == '0') || (a == '3' && b == '8') || (a == '4' && (b == '3' || b == '9')) ||
        (a == '5' && b >= '4') || (a == '9' && b == '2'))
      return true;
  }
  return false;
}

Joints between(const Joints& a, const Joints& b, double f) {
  const GrblAxes from = grbl_axes(a), to = grbl_axes(b);
  GrblAxes at{};
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = from[i] + (to[i] - from[i]) * f;
  return grbl_joints(at);
}

}  // namespace

/// Where the axes will stand when all that is planned is done.
Joints GrblController::planned_end() const {
  GrblAxes at = grbl_axes(reader_.modal().at);
  const GrblAxes shift = grbl_axes(offsets_.shift());
  for (std::size_t i = 0; i < at.size(); ++i) at[i] += shift[i];
  return grbl_joints(at);
}

/// The reader goes on from there, in program coordinates.
void GrblController::place_reader(const Joints& place) {
  GrblAxes at = grbl_axes(place);
  const GrblAxes shift = grbl_axes(offsets_.shift());
  for (std::size_t i = 0; i < at.size(); ++i) at[i] -= shift[i];
  reader_.set_position(grbl_joints(at));
  reader_.set_top(motion_.machine().z.max - shift[2]);
}

/// True when the line has codes of its own here and is answered, or will be.
bool GrblController::own_code() {
  if (!may_have_own_code(line_)) return false;
  const auto words = grbl_words(line_);
  if (!words) return false;
  const bool probes = has(*words, 382) || has(*words, 383);
  const bool offsets = has(*words, 100) || has(*words, 920) || has(*words, 921) || has(*words, 431);
  if (!probes && !offsets) return false;
  std::string rest;
  for (const auto& [letter, value] : *words)
    if ((letter == 'G' && tenths(value) >= 170 && tenths(value) != 382 && tenths(value) != 383 &&
         tenths(value) != 431 && tenths(value) / 10 != 92) ||
        letter == 'M')
      rest += letter + std::to_string(tenths(value) / 10) + " ";
  if (!reader_.read_line(rest, pending_)) return reply_error(static_cast<int>(reader_.fault())), true;
  pending_.clear();
  const int error = probes ? start_probe(*words) : set_offsets(*words);
  if (error != 0) {
    if (options_.latch_errors) latched_error_ = error;
    reply_error(error);
  } else if (check_mode_ || !probes) {
    cycle_ = Cycle::kNone;
    reply_ok();
  } else {
    reply_due_ = true;
    pump();
  }
  return true;
}

/// G54 to G59.3 and G49 act on the words of their own line: they are taken out of it.
void GrblController::select_system() {
  if (!may_have_own_code(line_)) return;
  const auto words = grbl_words(line_);
  if (!words) return;
  const Joints end = planned_end();
  if (has(*words, 490)) offsets_.tool() = {};
  for (const auto& [letter, value] : *words) {
    const int code = tenths(value);
    if (letter != 'G' || code < 540 || code > 593 || (code % 10 != 0 && code < 591)) continue;
    offsets_.select(static_cast<std::size_t>(code <= 590 ? code / 10 - 54 : 5 + code % 10));
    if (const std::size_t point = line_.find("59."); code > 590 && point != line_.npos)
      line_.erase(point + 2, 2);  // the reader knows G59
  }
  place_reader(end);
  reports_to_offset_ = 0;
}

/// G10 L2, G10 L20, G92, G92.1, G43.1. Returns an error number; 0: done.
int GrblController::set_offsets(const GrblWords& words) {
  const Joints end = planned_end();
  const GrblAxes here = offsets_.machine(end);
  const MachineModel& machine = motion_.machine();
  const char letters[] = {'X', 'Y', 'Z', machine.tilt.letter, machine.rotary.letter};
  GrblAxes* into = nullptr;
  bool from_here = has(words, 920);
  if (has(words, 921)) offsets_.g92() = {};
  if (has(words, 920)) into = &offsets_.g92();
  if (has(words, 431)) into = &offsets_.tool();
  if (has(words, 100)) {
    const auto l = word(words, 'L'), p = word(words, 'P');
    if (!l || !p) return kErrorMissingWord;
    if (*l != 2.0 && *l != 20.0) return kErrorUnsupported;
    if (*p != std::floor(*p) || *p < 0) return kErrorNotInteger;
    if (*p > static_cast<double>(GrblOffsets::kSystems)) return kErrorNoSystem;
    into = &offsets_.system(*p == 0.0 ? offsets_.selected() : static_cast<std::size_t>(*p) - 1);
    from_here = *l == 20.0;
  }
  bool any = has(words, 921);
  for (std::size_t i = 0; into != nullptr && i < here.size(); ++i) {
    const auto value = word(words, letters[i]);
    if (!value) continue;
    any = true;
    double others = from_here ? here[i] : 0.0;
    if (from_here && into != &offsets_.g92()) others -= offsets_.g92()[i] + offsets_.tool()[i];
    if (from_here && into == &offsets_.g92()) others -= offsets_.work()[i] - offsets_.g92()[i];
    (*into)[i] = from_here ? others - *value : *value;
  }
  if (!any) return kErrorNoAxes;
  place_reader(end);
  reports_to_offset_ = 0;
  return 0;
}

/// On the simulated axes; nothing where no axis is named.
std::optional<Joints> GrblController::target_of(const GrblWords& words, bool relative, bool machine,
                                                const Joints& from) {
  const MachineModel& model = motion_.machine();
  const char letters[] = {'X', 'Y', 'Z', model.tilt.letter, model.rotary.letter};
  GrblAxes to = grbl_axes(from);
  const GrblAxes shift = grbl_axes(offsets_.shift()), zero = offsets_.machine({});
  bool any = false;
  for (std::size_t i = 0; i < to.size(); ++i) {
    auto value = word(words, letters[i]);
    if (!value) continue;
    any = true;
    if (i < 3 && has(words, 200)) *value *= kInch;
    to[i] = machine ? *value - zero[i] : relative ? to[i] + *value : *value + shift[i];
  }
  return any ? std::optional(grbl_joints(to)) : std::nullopt;
}

// ---- jogs ------------------------------------------------------------------------------------------------

/// Returns an error number; 0: it waits for its place in the planner.
int GrblController::start_jog(std::string_view text) {
  const bool jogging = cycle_ == Cycle::kJog;
  if (alarm_ != 0 || check_mode_ || cycle_ == Cycle::kCancel ||
      (!jogging && !(motion_.idle() && !motion_.held())))
    return kErrorNotIdle;
  const auto words = grbl_words(text);
  if (!words) return static_cast<int>(Fault::kBadNumber);
  const MachineModel& model = motion_.machine();
  const std::string axes = std::string("XYZ") + model.tilt.letter + model.rotary.letter;
  for (const auto& [letter, value] : *words) {
    const int code = tenths(value);
    if (letter == 'G' && (code == 200 || code == 210 || code == 900 || code == 910 || code == 530)) continue;
    if (letter != 'F' && letter != 'N' && axes.find(letter) == axes.npos) return kErrorJogWord;
  }
  const auto feed = word(*words, 'F');
  if (!feed || *feed <= 0.0) return kErrorNoFeed;
  const bool relative = has(*words, 910) || (!has(*words, 900) && reader_.modal().relative);
  const auto target = target_of(*words, relative, has(*words, 530), planned_end());
  if (!target) return kErrorNoAxes;
  if (settings_.value(kSoftLimits) != 0.0 && motion_.outside(*target)) return kErrorTravel;
  Block block;
  block.op = Op::kFeed;
  block.target = *target;
  block.feed = *feed * (has(*words, 200) ? kInch : 1.0);
  pending_.assign(1, block);
  placed_ = 0;
  cycle_ = Cycle::kJog;
  place_reader(*target);
  return 0;
}

/// The axes brake; what was planned is forgotten, and so is what came behind it.
void GrblController::cancel_jog() {
  rx_.clear();
  rx_read_ = 0;
  line_.clear();
  if (cycle_ != Cycle::kJog) return;
  if (reply_due_) reply_ok();
  pending_.clear();
  placed_ = 0;
  cycle_ = Cycle::kCancel;
  motion_.hold();
  pump();
}

// ---- homing ----------------------------------------------------------------------------------------------

/// Returns an error number; 0: it is under way.
int GrblController::start_homing(std::string_view axis) {
  if (settings_.value(kHoming) == 0.0 || !axis.empty()) return kErrorHomingOff;
  if (reset_needed_) return kErrorLocked;
  if (!(motion_.idle() && !motion_.held()) || check_mode_) return kErrorNotIdle;
  const MachineModel& m = motion_.machine();
  const double off = settings_.value(kPullOff);
  const auto invert = static_cast<unsigned>(settings_.value(kHomingDirection));
  const auto home = [&](const LinearAxis& one, unsigned bit) {
    return (invert >> bit & 1U) != 0 ? one.min + off : one.max - off;
  };
  const auto turned = [](const RotaryAxis& one) {
    return std::clamp(one.zero, one.min, std::max(one.min, one.max));
  };
  Joints at = motion_.position();
  at.z = home(m.z, 2);
  home_way_.assign(1, at);
  at.x = home(m.x, 0), at.y = home(m.y, 1);
  home_way_.push_back(at);
  at.a = turned(m.tilt), at.c = turned(m.rotary);
  home_way_.push_back(at);
  std::reverse(home_way_.begin(), home_way_.end());  // the next is the last
  alarm_ = 0;
  cycle_ = Cycle::kHome;
  return 0;
}

// ---- probing ---------------------------------------------------------------------------------------------

/// Returns an error number; 0: it begins when the axes stand.
int GrblController::start_probe(const GrblWords& words) {
  const auto target = target_of(words, reader_.modal().relative, false, planned_end());
  if (!target) return kErrorNoAxes;
  const double feed = word(words, 'F').value_or(reader_.modal().inverse_time ? 0.0 : reader_.modal().feed);
  if (feed <= 0.0) return kErrorNoFeed;
  probe_ = {};
  probe_.op = Op::kFeed;
  probe_.target = *target;
  probe_.feed = feed;
  probe_.m_code = has(words, 382) ? 1 : 0;  // whether a miss is an alarm
  cycle_ = Cycle::kProbeWaits;
  return 0;
}

/// The axes brake when the plate is touched, and so end a little beyond it.
void GrblController::begin_probe() {
  const Joints from = motion_.position();
  const double top = offsets_.machine({})[2], plate = options_.plate.value_or(-1e9) - top;
  touches_ = false;
  if (options_.plate && from.z <= plate) {
    cycle_ = Cycle::kNone;
    return soft_alarm(kAlarmProbeTouches);
  }
  const double down = from.z - probe_.target.z;
  if (options_.plate && probe_.target.z <= plate) {
    const double touch = (from.z - plate) / down, a = motion_.machine().z.acceleration;
    const double speed = probe_.feed / 60.0, braking = a > 0.0 ? speed * speed / (2.0 * a) : 0.0;
    touches_ = true;
    touched_ = offsets_.machine(between(from, probe_.target, touch));
    probe_.target = between(from, probe_.target, std::min(1.0, touch + braking / down));
  } else {
    touched_ = offsets_.machine(probe_.target);
  }
  Block move = probe_;
  move.m_code = -1;
  cycle_ = Cycle::kProbe;
  motion_.push(move);
  motion_.advance(motion_.now());
}

void GrblController::end_probe() {
  cycle_ = Cycle::kNone;
  place_reader(motion_.position());
  std::vector<Block> none;
  static_cast<void>(reader_.read_line("G80", none));
  if (!touches_ && probe_.m_code == 1) soft_alarm(kAlarmNoContact);
  out_ += "[PRB:" + grbl_text(touched_) + (touches_ ? ":1" : ":0") + "]\r\n";
}

/// True when what keeps the due line from its reply is over.
bool GrblController::follow_cycle() {
  if (cycle_ == Cycle::kProbeWaits && motion_.idle()) begin_probe();
  if (cycle_ == Cycle::kProbe && motion_.idle() && !motion_.held()) end_probe();
  while (cycle_ == Cycle::kHome && !home_way_.empty() && motion_.idle()) {
    Block move;
    move.target = home_way_.back();
    home_way_.pop_back();
    motion_.push(move);
    motion_.advance(motion_.now());
  }
  if (cycle_ == Cycle::kHome && home_way_.empty() && motion_.idle()) {
    cycle_ = Cycle::kNone;
    place_reader(motion_.position());
    if (!options_.home_switches) {
      alarm_ = kAlarmHomingFailed;
      out_ += "ALARM:9\r\n";
      reset();
      return false;
    }
  }
  return cycle_ != Cycle::kProbeWaits && cycle_ != Cycle::kProbe && cycle_ != Cycle::kHome;
}

/// The machine is locked, and $X unlocks it without a reset.
void GrblController::soft_alarm(int code) {
  alarm_ = code;
  out_ += "ALARM:" + std::to_string(code) + "\r\n[MSG:'$H'|'$X' to unlock]\r\n";
}

}  // namespace tiltfeed::sim
