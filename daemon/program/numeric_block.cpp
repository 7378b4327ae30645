#include "daemon/program/numeric_block.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

namespace tiltfeed::daemon {

namespace {

constexpr const char* kNoBlock =
    " cannot be sent as a numeric block; post for this link with the dialect grbl (program.dialect, post "
    "--dialect)";

constexpr char kAxisNames[] = "XYZAC";
constexpr std::uint8_t kEveryAxis = 0x1f;
constexpr double kWholeTurn = 2.0 * std::numbers::pi;
/// Largest S, 1/min: the wire counts thousandths in an int32.
constexpr double kMaxSpindle = 2147483.0;
/// Longest dwell, s: an hour; the wire counts milliseconds.
constexpr double kMaxDwell = 3600.0;
/// Feeds, 1/min or mm/min: the wire counts thousandths in a uint32.
constexpr double kMinFeed = 0.001, kMaxFeed = 4294967.0;

std::string show(char letter, double value) {
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, value);
  return letter + std::string(digits, end.ptr);
}

}  // namespace

std::optional<GcodeWord> take_word(std::string_view& rest) {
  if (rest.size() < 2 || rest[0] < 'A' || rest[0] > 'Z') return std::nullopt;
  const char* from = rest.data() + 1;
  const char* end = rest.data() + rest.size();
  if (*from == '+' && from + 1 < end && from[1] != '-') ++from;
  const char* digits = from < end && *from == '-' ? from + 1 : from;
  if (digits == end || !((*digits >= '0' && *digits <= '9') || *digits == '.')) return std::nullopt;
  GcodeWord word{rest[0], 0.0};
  const auto parsed = std::from_chars(from, end, word.value, std::chars_format::fixed);
  if (parsed.ec != std::errc()) return std::nullopt;
  rest.remove_prefix(static_cast<std::size_t>(parsed.ptr - rest.data()));
  return word;
}

NumericAxes numeric_axes(const MachineModel& machine) {
  return {true, machine.tilt.present ? machine.tilt.letter : '\0',
          machine.rotary.present ? machine.rotary.letter : '\0'};
}

/// Whatever stands before it in the line.
std::optional<bool> relative_in(std::string_view line) {
  std::optional<bool> found;
  while (const std::optional<GcodeWord> word = take_word(line))
    if (word->letter == 'G' && (word->value == 90.0 || word->value == 91.0)) found = word->value == 91.0;
  return found;
}

BlockReader::BlockReader(const NumericAxes& axes, bool lines) : names_(axes), lines_(lines) {
  if (!axes.known) return;
  known_[3] = axes.tilt == 0;
  known_[4] = axes.rotary == 0;
}

/// What one line says, before it is put into order.
struct BlockReader::Parsed {
  bool moves = false, dwells = false, has_f = false, has_s = false, has_p = false;
  bool tolerance = false;  // G64, whose P is a tolerance
  bool machine = false;    // G53
  double centre[3] = {};   // I J K of an arc
  bool has_centre = false;
  double from[5] = {};  // where the axes were before the line
  unsigned stated = 0;  // axes, a bit each
  double f = 0.0, p = 0.0;
  int spindle_code = -1, stop_code = -1;
  int coolant[2] = {-1, -1};  // M7 and M8 may stand on one line
  int coolants = 0;
};

Result<void> BlockReader::take_g(double value, Parsed& parsed) {
  if (!(value >= 0.0 && value < kLargestCode)) return fail(Code::kInput, show('G', value) + " is not a code");
  switch (static_cast<int>(std::lround(value * 10.0))) {
    case 0:
      motion_set_ = rapid_ = true;
      arc_ = 0;
      return {};
    case 10:
      motion_set_ = true;
      rapid_ = false;
      arc_ = 0;
      return {};
    case 20:
    case 30:
    case 180:
    case 190:
      if (!lines_)
        return fail(Code::kInput, show('G', value) +
                                      ": no arc can be sent as a numeric block; plan or post without arcs "
                                      "(program.arc_tolerance_mm, post --arc-tolerance)");
      if (value >= 18.0) return plane_ = static_cast<int>(value), Result<void>{};
      motion_set_ = true;
      rapid_ = false;
      arc_ = static_cast<int>(value);
      return {};
    case 170:
      plane_ = 17;
      return {};
    case 40:
      parsed.dwells = true;
      return {};
    case 930:
      inverse_time_ = true;
      return {};
    case 940:
      inverse_time_ = false;
      feed_ = 0.0;
      return {};
    case 640:
      parsed.tolerance = true;
      return {};
    case 530:
      parsed.machine = true;
      return {};
    case 210:
    case 400:
    case 490:
    case 540:
    case 610:
    case 800:
    case 900:
    case 970:
      return {};
    case 200:
      return fail(Code::kInput, "G20: inches are not supported; post the program in millimetres");
    case 910:
      if (lines_) return {};
      return fail(Code::kInput, "G91: relative moves are not supported; post the program with G90");
    default:
      return fail(Code::kInput, show('G', value) + kNoBlock);
  }
}

Result<void> BlockReader::take_m(double value, Parsed& parsed) {
  const int code = value >= 0.0 && value < kLargestCode ? static_cast<int>(value) : -1;
  if (code != value) return fail(Code::kInput, show('M', value) + " is not a code");
  switch (code) {
    case 0:
    case 1:
    case 2:
    case 30:
      if (parsed.stop_code >= 0) return fail(Code::kInput, "two of M0 M1 M2 M30 in one line");
      parsed.stop_code = code;
      return {};
    case 3:
    case 4:
    case 5:
      if (parsed.spindle_code >= 0) return fail(Code::kInput, "two of M3 M4 M5 in one line");
      parsed.spindle_code = code;
      return {};
    case 6:
    case 7:
    case 8:
    case 9:
      if (parsed.coolants == 2) return fail(Code::kInput, "more than two of M6 M7 M8 M9 in one line");
      parsed.coolant[parsed.coolants++] = code;
      return {};
    default:
      return fail(Code::kInput, show('M', value) + kNoBlock);
  }
}

Result<void> BlockReader::take_axis(const GcodeWord& word, Parsed& parsed) {
  int axis = 0;
  if (names_.known && word.letter < 'X') {
    if (word.letter != names_.tilt && word.letter != names_.rotary)
      return fail(Code::kInput, show(word.letter, word.value) + ": the machine has no such axis");
    axis = word.letter == names_.tilt ? 3 : 4;
  } else if (word.letter == 'A' || word.letter == 'B') {
    if (tilt_letter_ != 0 && tilt_letter_ != word.letter)
      return fail(Code::kInput, "both A and B are programmed; the head has one of them");
    tilt_letter_ = word.letter;
    axis = 3;
  } else {
    axis = word.letter == 'C' ? 4 : word.letter - 'X';
  }
  parsed.stated |= 1U << axis;
  parsed.moves = true;
  if (relative_) return {};
  axes_[axis] = word.value;
  known_[axis] = true;
  lost_ = static_cast<std::uint8_t>(lost_ & ~(1U << axis));
  return {};
}

Result<void> BlockReader::take_other(const GcodeWord& word, Parsed& parsed) {
  switch (word.letter) {
    case 'N':
    case 'T':
      return {};
    case 'F':
      if (word.value < kMinFeed || word.value > kMaxFeed)
        return fail(Code::kLimit, show('F', word.value) + " is outside " + show('F', kMinFeed) + " to " +
                                      show('F', kMaxFeed));
      parsed.has_f = true;
      parsed.f = word.value;
      return {};
    case 'S':
      if (word.value < 0.0 || word.value > kMaxSpindle)
        return fail(Code::kLimit, show('S', word.value) + " is outside S0 to " + show('S', kMaxSpindle));
      parsed.has_s = true;
      spindle_ = word.value;
      return {};
    case 'I':
    case 'J':
    case 'K':
      if (arc_ == 0) return fail(Code::kInput, show(word.letter, word.value) + " belongs to no G2 or G3");
      parsed.has_centre = true;
      parsed.centre[word.letter - 'I'] = word.value;
      return {};
    case 'P':
      parsed.has_p = true;
      parsed.p = word.value;
      return {};
    default:
      return fail(Code::kInput, show(word.letter, word.value) + kNoBlock);
  }
}

std::uint8_t BlockReader::absent() const {
  return static_cast<std::uint8_t>((names_.known && names_.tilt == 0 ? 8 : 0) |
                                   (names_.known && names_.rotary == 0 ? 16 : 0));
}

NumericBlock BlockReader::block_here(BlockOp op, const Line& line) const {
  NumericBlock block{op,  false, line.number, axes_[0], axes_[1],  axes_[2], axes_[3], axes_[4],
                     0.0, 0.0,   0,           spindle_, line.text, 0,        false};
  block.absent = absent();
  return block;
}

void BlockReader::add_m(int code, const Line& line, std::vector<NumericBlock>& blocks) const {
  NumericBlock block = block_here(BlockOp::kMCode, line);
  block.m_code = code;
  blocks.push_back(std::move(block));
}

void BlockReader::add_relative(const Line& line, const Parsed& parsed, std::vector<NumericBlock>& blocks) {
  NumericBlock block = block_here(rapid_ ? BlockOp::kRapid : BlockOp::kFeed, line);
  block.inverse_time = !rapid_ && inverse_time_;
  block.feed = rapid_ ? 0.0 : block.inverse_time ? parsed.f : feed_;
  block.kept = kEveryAxis;
  block.lost = static_cast<std::uint8_t>(parsed.stated);
  blocks.push_back(std::move(block));
  lost_ = static_cast<std::uint8_t>(lost_ | parsed.stated);
  for (int axis = 0; axis < 5; ++axis)
    if ((parsed.stated >> axis & 1U) != 0) known_[axis] = false;
}

/// Round the centre from where the axes were; the third axis of the plane goes evenly.
Result<void> BlockReader::take_arc(const Parsed& parsed, NumericBlock& block) const {
  if (relative_) return fail(Code::kInput, "an arc in G91 is not understood");
  if (!parsed.has_centre)
    return fail(Code::kInput, "an arc without I J K; one by its radius is not understood");
  const int first = plane_ == 18   ? 2
                    : plane_ == 19 ? 1
                                   : 0,
            second = (first + 1) % 3, third = (first + 2) % 3;
  const double u = -parsed.centre[first], v = -parsed.centre[second];
  const double radius = std::hypot(u, v);
  const double to_u = axes_[first] - parsed.from[first] + u, to_v = axes_[second] - parsed.from[second] + v;
  const double begin = std::atan2(v, u);
  double turn = std::atan2(to_v, to_u) - begin;
  if (arc_ == 2 && turn >= 0.0) turn -= kWholeTurn;
  if (arc_ == 3 && turn <= 0.0) turn += kWholeTurn;
  block.way = std::hypot(turn * 0.5 * (radius + std::hypot(to_u, to_v)), axes_[third] - parsed.from[third]);
  // Where it goes over the circle's highest place, that is higher than both of its ends.
  if (first != 2 && second != 2) return {};
  const double up = first == 2 ? 0.0 : kWholeTurn / 4.0;
  const double to_top = std::remainder(up - begin, kWholeTurn);
  const auto passes = [&](double angle) {
    return turn > 0.0 ? angle > 0.0 && angle < turn : angle < 0.0 && angle > turn;
  };
  const double to_z = first == 2 ? to_u : to_v;
  if (passes(to_top) || passes(to_top + kWholeTurn) || passes(to_top - kWholeTurn))
    block.rise = std::max(radius - to_z, 0.0);
  return {};
}

Result<void> BlockReader::add_move(const Line& line, const Parsed& parsed,
                                   std::vector<NumericBlock>& blocks) {
  if (!motion_set_) return fail(Code::kInput, "axis words before the first G0 or G1");
  if (relative_ && arc_ == 0) return add_relative(line, parsed, blocks), Result<void>{};
  unsigned kept = 0;
  for (int axis = 0; axis < 5; ++axis) {
    if ((absent() >> axis & 1) != 0) continue;
    if (known_[axis] && (!parsed.machine || (parsed.stated >> axis & 1U) != 0)) continue;
    if (!rapid_)
      return fail(Code::kInput,
                  std::string(1, axis == 3 && names_.tilt != 0     ? names_.tilt
                                 : axis == 4 && names_.rotary != 0 ? names_.rotary
                                                                   : kAxisNames[axis]) +
                      " has no value yet: rapids before the first feed move must state all axes "
                      "that the machine has");
    kept |= 1U << axis;
  }
  if (!rapid_ && inverse_time_ && !parsed.has_f)
    return fail(Code::kInput, "no F: in inverse time (G93) every G1 line needs one");
  if (!rapid_ && !inverse_time_ && feed_ == 0.0) return fail(Code::kInput, "no F yet for this G1");
  NumericBlock block = block_here(rapid_ ? BlockOp::kRapid : BlockOp::kFeed, line);
  if (!rapid_) {
    block.inverse_time = inverse_time_;
    block.feed = inverse_time_ ? parsed.f : feed_;
  }
  if (arc_ != 0)
    if (const Result<void> arc = take_arc(parsed, block); !arc) return arc;
  block.kept = static_cast<std::uint8_t>(kept);
  block.machine = parsed.machine;
  blocks.push_back(std::move(block));
  for (int axis = 0; parsed.machine && axis < 5; ++axis)
    if ((parsed.stated >> axis & 1U) != 0) known_[axis] = false;
  return {};
}

Result<void> BlockReader::read(const Line& line, std::vector<NumericBlock>& blocks) {
  Parsed parsed;
  std::copy(std::begin(axes_), std::end(axes_), parsed.from);
  std::string_view rest = line.text;
  const double spindle = spindle_;
  if (lines_) relative_ = relative_in(line.text).value_or(relative_);
  while (!rest.empty()) {
    const std::size_t column = line.text.size() - rest.size();
    const std::optional<GcodeWord> word = take_word(rest);
    if (!word)
      return fail(Code::kInput,
                  "'" + line.text.substr(column) + "' does not start with a letter and a number");
    Result<void> taken;
    switch (word->letter) {
      case 'G':
        taken = take_g(word->value, parsed);
        break;
      case 'M':
        taken = take_m(word->value, parsed);
        break;
      case 'X':
      case 'Y':
      case 'Z':
      case 'A':
      case 'B':
      case 'C':
        taken = take_axis(*word, parsed);
        break;
      default:
        taken = take_other(*word, parsed);
    }
    if (!taken) return taken;
  }
  if (lines_ && parsed.dwells && parsed.has_s && !parsed.has_p) {  // RepRap: seconds
    parsed.has_p = true, parsed.has_s = false;
    parsed.p = std::exchange(spindle_, spindle);
  }
  if (parsed.has_f && !inverse_time_) feed_ = parsed.f;
  if (parsed.spindle_code >= 0) spindle_code_ = parsed.spindle_code;
  if (parsed.spindle_code >= 0 || (parsed.has_s && spindle_code_ != 5)) add_m(spindle_code_, line, blocks);
  for (int i = 0; i < parsed.coolants; ++i) add_m(parsed.coolant[i], line, blocks);
  if (parsed.dwells) {
    if (!parsed.has_p || parsed.p < 0.0 || parsed.p > kMaxDwell)
      return fail(Code::kLimit, "G4 needs P, 0 to " + show('P', kMaxDwell) + " seconds");
    NumericBlock block = block_here(BlockOp::kDwell, line);
    block.seconds = parsed.p;
    blocks.push_back(std::move(block));
  } else if (parsed.has_p && !parsed.tolerance) {
    return fail(Code::kInput, show('P', parsed.p) + " belongs to no G4 or G64");
  }
  if (parsed.moves) {
    if (const Result<void> moved = add_move(line, parsed, blocks); !moved) return moved;
  }
  if (parsed.stop_code >= 0) add_m(parsed.stop_code, line, blocks);
  return {};
}

}  // namespace tiltfeed::daemon
