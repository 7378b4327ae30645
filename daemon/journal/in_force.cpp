#include "daemon/journal/in_force.h"

#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

constexpr double kMostTool = 1e6;
constexpr int kPrintedFeed = 4;
constexpr int kUsualPlane = 17;

/// 0 where the machine has no such axis.
char letter_of(const MachineModel& machine, int axis) {
  if (axis < 3) return "XYZ"[axis];
  const RotaryAxis& turns = axis == 3 ? machine.tilt : machine.rotary;
  return turns.present ? turns.letter : '\0';
}

}  // namespace

void InForce::take(const NumericBlock& b) {
  if (b.op == BlockOp::kMCode) {
    if (b.m_code >= 3 && b.m_code <= 5) spindle_code = b.m_code;
    if (b.m_code == 7) mist = true;
    if (b.m_code == 8) flood = true;
    if (b.m_code == 9) mist = flood = false;
    spindle = b.spindle;
    return;
  }
  if (b.op == BlockOp::kDwell) return;
  const double to[kAxes] = {b.x, b.y, b.z, b.tilt, b.rotary};
  for (int i = 0; i < kAxes; ++i) {
    if ((b.lost >> i & 1) != 0) place[i] = Place::kUnsaid;
    if ((b.kept >> i & 1) != 0) continue;
    place[i] = b.machine ? Place::kMachine : Place::kProgram;
    at[i] = to[i];
  }
}

void InForce::take_words(std::string_view line) {
  bool changed = false;
  std::optional<double> stated;
  while (const std::optional<GcodeWord> word = take_word(line)) {
    if (word->letter == 'F') stated = word->value;
    if (word->letter == 'T' && word->value >= 0.0 && word->value < kMostTool)
      chosen = static_cast<int>(word->value);
    changed = changed || (word->letter == 'M' && word->value == 6.0);
    if (word->letter != 'G') continue;
    if (word->value >= 0.0 && word->value <= 3.0) rapid = word->value == 0.0, arc = word->value >= 2.0;
    if (word->value >= 17.0 && word->value <= 19.0) plane = static_cast<int>(word->value);
    if (word->value != 93.0 && word->value != 94.0) continue;
    if (inverse_time != (word->value == 93.0)) feed = 0.0;  // F means another thing now
    inverse_time = word->value == 93.0;
  }
  if (stated) feed = *stated;
  if (changed) chosen.reset();
}

bool InForce::is_placed(const MachineModel& machine) const {
  return letters(machine, Place::kUnsaid).empty() && letters(machine, Place::kMachine).empty();
}

std::string InForce::letters(const MachineModel& machine, Place which) const {
  std::string found;
  for (int i = 0; i < kAxes; ++i)
    if (const char letter = letter_of(machine, i); letter != 0 && place[i] == which) found += letter;
  return found;
}

std::string InForce::words(const config::MachineProfile& machine, Place which,
                           std::string_view letters) const {
  std::string found;
  for (int i = 0; i < kAxes; ++i) {
    const char letter = letter_of(machine.model, i);
    if (letter == 0 || place[i] != which || letters.find(i < 3 ? letter : 'R') == letters.npos) continue;
    const int decimals = i < 3 ? machine.format.linear_decimals : machine.format.rotary_decimals;
    found += std::string(" ") + letter + decimal(at[i], decimals);
  }
  return found;
}

/// In inverse time a G1 without F is an error even where nothing moves, and every move states its own F: so
/// the motion mode comes first.
std::vector<std::string> InForce::mode_lines(double feed_before) const {
  const bool known = !inverse_time && feed > 0.0;
  std::vector<std::string> lines;
  if (rapid)
    lines.push_back(known ? "G0 F" + decimal(feed, kPrintedFeed) : "G0");
  else
    lines.push_back("G1 F" + decimal(known ? feed : feed_before, kPrintedFeed));
  if (inverse_time) lines.push_back("G93");
  if (plane != kUsualPlane) lines.push_back("G" + std::to_string(plane));
  return lines;
}

}  // namespace tiltfeed::daemon
