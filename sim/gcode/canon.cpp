#include "sim/gcode/canon.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <string_view>

#include "sim/gcode/arc_way.h"

namespace tiltfeed::sim {
namespace {

// Rates are printed with four decimals: a way so short that its rate rounds to zero gets the least one.
constexpr double kLeastRate = 1e-4;  // mm/min
constexpr std::size_t kMostNumbers = 12;

/// One line: its number and the command with its arguments.
struct Command {
  std::uint32_t number = 0;
  std::string_view name, arguments;
};

constexpr std::string_view kBlank = " \t\r";

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

template <class Number>
bool read_number(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

/// "   15 N..... NAME(arguments)"
std::optional<Command> split(std::string_view line) {
  Command command;
  line = trim(line);
  const std::size_t first = line.find(' '), open = line.find('(');
  if (first == std::string_view::npos || open == std::string_view::npos || !line.ends_with(')'))
    return std::nullopt;
  if (!read_number(line.substr(0, first), command.number)) return std::nullopt;
  std::string_view head = trim(line.substr(first, open - first));
  const std::size_t blank = head.find_last_of(' ');
  if (blank == std::string_view::npos || head[0] != 'N') return std::nullopt;
  command.name = head.substr(blank + 1);
  command.arguments = line.substr(open + 1, line.size() - open - 2);
  return command;
}

/// The numbers between commas or blanks; nothing when one is malformed.
std::optional<std::vector<double>> numbers(std::string_view text) {
  std::vector<double> values;
  while (!(text = trim(text)).empty()) {
    const std::size_t end = std::min(text.find_first_of(", "), text.size());
    double value = 0.0;
    if (!read_number(text.substr(0, end), value) || values.size() == kMostNumbers) return std::nullopt;
    values.push_back(value);
    text = trim(text.substr(end));
    if (text.starts_with(',')) text.remove_prefix(1);
  }
  return values;
}

// Commands that move nothing and change nothing that this machine has.
constexpr std::string_view kHarmless[] = {"COMMENT",
                                          "MESSAGE",
                                          "ON_RESET",
                                          "SET_FEED_REFERENCE",
                                          "SET_FEED_MODE",
                                          "FLOOD_ON",
                                          "FLOOD_OFF",
                                          "MIST_ON",
                                          "MIST_OFF",
                                          "START_CHANGE",
                                          "SET_SPINDLE_MODE",
                                          "OPTIONAL_PROGRAM_STOP",
                                          "SET_NAIVECAM_TOLERANCE",
                                          "PALLET_SHUTTLE"};
// Commands that move the zero or the units: harmless only while every number but the first is zero.
constexpr std::string_view kOffsets[] = {"SET_G5X_OFFSET", "SET_G92_OFFSET", "SET_XY_ROTATION",
                                         "USE_TOOL_LENGTH_OFFSET"};

bool among(std::string_view name, std::span<const std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

class Reader {
 public:
  explicit Reader(const MachineModel& machine) : machine_(machine) {}

  /// What is wrong with the command, or nothing.
  std::optional<std::string> take(const Command& command, std::vector<Block>& blocks);
  bool ended() const { return ended_; }

 private:
  std::optional<std::string> take_values(const Command& command, const std::vector<double>& values,
                                         std::vector<Block>& blocks);
  std::optional<std::string> take_move(bool rapid, const std::vector<double>& values, Block& block);
  void follow_retract(const std::vector<double>& values, Block& block);
  std::optional<std::string> take_setting(const Command& command, const std::vector<double>& values);
  std::optional<int> m_code(std::string_view name) const;
  std::optional<std::string> take_arc(const std::vector<double>& values, Block block,
                                      std::vector<Block>& blocks);

  const MachineModel& machine_;
  Joints at_;
  double rate_ = -1.0, spindle_ = 0.0;  ///< rate below 0: none yet
  // SELECT_TOOL chooses, CHANGE_TOOL changes; before any change the chosen one counts, as in a program.
  int selected_ = kToolNotSaid, tool_ = kToolNotSaid;
  bool tool_changed_ = false;
  bool exact_stop_ = false, ended_ = false;
  int plane_ = 17;            ///< of arcs
  std::vector<double> last_;  ///< numbers of the last move; empty before the first
  bool placed_ = true, retracted_ = false;
};

std::optional<std::string> Reader::take_move(bool rapid, const std::vector<double>& values, Block& block) {
  constexpr std::string_view kLetters = "ABC";
  if (values.size() != 6) return "a move has six numbers: x, y, z, a, b, c";
  if (!rapid && rate_ < 0.0) return "a feed move before SET_FEED_RATE";
  const auto word = [&](const RotaryAxis& axis, double at) {
    return turned_to(axis.word, values[3 + kLetters.find(axis.letter)], at);
  };
  at_ = {values[0], values[1], values[2], word(machine_.tilt, at_.a), word(machine_.rotary, at_.c)};
  block.op = rapid ? Op::kRapid : Op::kFeed;
  block.feed = rapid ? 0.0 : std::max(rate_, kLeastRate);
  block.exact_stop = exact_stop_;
  follow_retract(values, block);
  return std::nullopt;
}

/// Where all tables are empty, the machine's zero is the program's: a traverse of nothing but Z, to 0, is
/// G53 Z0, the end of Z's travel. It lasts until Z moves again.
void Reader::follow_retract(const std::vector<double>& values, Block& block) {
  const bool first = last_.empty();
  if (first) last_.assign(values.size(), 0.0);
  const bool level = values[2] == last_[2];
  bool others = false;
  for (std::size_t i = 0; i < values.size(); ++i) others = others || (i != 2 && values[i] != last_[i]);
  const bool retract = block.op == Op::kRapid && values[2] == 0.0 && !others && (first || !level);
  if (first && retract) placed_ = false;  // where X and Y are is not known before they are stated
  placed_ = placed_ || block.op == Op::kFeed || values[0] != last_[0] || values[1] != last_[1];
  block.placed = placed_;
  block.off_path = retracted_ || retract;
  retracted_ = retract || (retracted_ && level);
  if (retracted_) at_.z = machine_.z.max;
  last_ = values;
}

/// ARC_FEED(first end, second end, first centre, second centre, turns, third end, a, b, c); turns: 1 is up to
/// once round anticlockwise, -1 clockwise.
std::optional<std::string> Reader::take_arc(const std::vector<double>& values, Block block,
                                            std::vector<Block>& blocks) {
  if (values.size() != 9) return "an arc has nine numbers";
  if (rate_ < 0.0) return "an arc before SET_FEED_RATE";
  if (values[4] != 1.0 && values[4] != -1.0) return "an arc of more than one turn is not understood";
  if (last_.empty() || retracted_) return "an arc from a place that is not known";
  const ArcPlane& plane = arc_plane(plane_);
  const ArcWords arc{plane_, values[4] < 0.0, values[2], values[3]};
  const Joints from = at_;
  Joints to = at_;
  to.*plane.first = values[0], to.*plane.second = values[1], to.*plane.third = values[5];
  if (auto wrong = arc_is_wrong(from, to, arc)) return wrong;
  if (std::vector<double>(values.begin() + 6, values.end()) !=
      std::vector<double>(last_.begin() + 3, last_.end()))
    return "an arc in which a rotary turns is not understood";
  const ArcWay way(from, to, arc);
  const int pieces = way.pieces();
  block.op = Op::kFeed;
  block.feed = std::max(rate_, kLeastRate);
  for (int i = 1; i <= pieces; ++i) {
    block.target = way.at(static_cast<double>(i) / pieces);
    block.goes_on = i < pieces;
    block.exact_stop = exact_stop_ && i == pieces;
    blocks.push_back(block);
  }
  at_ = to;
  last_[0] = to.x, last_[1] = to.y, last_[2] = to.z;
  return std::nullopt;
}

std::optional<int> Reader::m_code(std::string_view name) const {
  if (name == "START_SPINDLE_CLOCKWISE") return 3;
  if (name == "START_SPINDLE_COUNTERCLOCKWISE") return 4;
  if (name == "STOP_SPINDLE_TURNING") return 5;
  if (name == "PROGRAM_STOP") return 0;
  if (name == "PROGRAM_END") return 2;
  return std::nullopt;
}

/// Commands without a block.
std::optional<std::string> Reader::take_setting(const Command& command, const std::vector<double>& values) {
  if (among(command.name, kOffsets)) {
    const std::size_t from = command.name == "SET_G5X_OFFSET" ? 1 : 0;
    for (std::size_t i = from; i < values.size(); ++i)
      if (values[i] != 0.0) return "offsets are not in this machine; run rs274 with empty tables";
    return std::nullopt;
  }
  if (command.name == "SET_FEED_RATE" && values.size() == 1 && values[0] >= 0.0) {
    rate_ = values[0];
  } else if (command.name == "SET_SPINDLE_SPEED" && !values.empty()) {
    spindle_ = values.back();
  } else if (command.name == "SELECT_TOOL" && values.size() == 1 && values[0] >= 0.0) {
    selected_ = static_cast<int>(std::min(values[0], kMostTool));
    if (!tool_changed_) tool_ = selected_;
  } else {
    return "this machine has no such command";
  }
  return std::nullopt;
}

std::optional<std::string> Reader::take_values(const Command& command, const std::vector<double>& values,
                                               std::vector<Block>& blocks) {
  Block block;
  block.line = command.number;
  block.spindle = spindle_;
  block.tool = tool_;
  if (command.name == "STRAIGHT_TRAVERSE" || command.name == "STRAIGHT_FEED") {
    if (auto wrong = take_move(command.name == "STRAIGHT_TRAVERSE", values, block)) return wrong;
  } else if (command.name == "ARC_FEED") {
    return take_arc(values, block, blocks);
  } else if (command.name == "DWELL" && values.size() == 1 && values[0] >= 0.0) {
    block.op = Op::kDwell, block.feed = values[0];
  } else if (const auto code = m_code(command.name)) {
    block.op = Op::kMCode, block.m_code = *code;
    ended_ = *code == 2;
  } else {
    return take_setting(command, values);
  }
  block.target = at_;
  blocks.push_back(block);
  return std::nullopt;
}

std::optional<std::string> Reader::take(const Command& command, std::vector<Block>& blocks) {
  if (among(command.name, kHarmless)) return std::nullopt;
  if (command.name == "USE_LENGTH_UNITS")
    return command.arguments == "CANON_UNITS_MM"
               ? std::nullopt
               : std::optional<std::string>("inches are refused; use G21 and mm");
  if (command.name == "SET_MOTION_CONTROL_MODE") {
    exact_stop_ = !command.arguments.starts_with("CANON_CONTINUOUS");
    return std::nullopt;
  }
  if (command.name == "SELECT_PLANE") {
    constexpr std::array<std::string_view, 3> kPlanes{"CANON_PLANE_XY", "CANON_PLANE_XZ", "CANON_PLANE_YZ"};
    const auto* const found = std::find(kPlanes.begin(), kPlanes.end(), command.arguments);
    if (found == kPlanes.end()) return "this machine has no such plane";
    plane_ = 17 + static_cast<int>(found - kPlanes.begin());
    return std::nullopt;
  }
  // Its number is the slot that the tool comes from, in some versions.
  if (command.name == "CHANGE_TOOL") {
    tool_changed_ = true, tool_ = selected_;
    return std::nullopt;
  }
  const auto values = numbers(command.arguments);
  if (!values) return "a number is malformed";
  return take_values(command, *values, blocks);
}

}  // namespace

Result<std::vector<Block>> read_canon(std::istream& in, const std::string& name,
                                      const MachineModel& machine) {
  for (const RotaryAxis* axis : {&machine.tilt, &machine.rotary})
    if (axis->letter < 'A' || axis->letter > 'C')
      return fail(Code::kInput, name + ": rs274 prints the rotary words A B C only; this machine has " +
                                    std::string(1, axis->letter));
  Reader reader(machine);
  std::vector<Block> blocks;
  std::string line;
  for (std::uint64_t number = 1; !reader.ended() && std::getline(in, line); ++number) {
    if (trim(line).empty()) continue;
    const auto wrong = [&](const std::string& what) {
      return fail(Code::kInput, name + ":" + std::to_string(number) + ": " + what);
    };
    const std::optional<Command> command = split(line);
    if (!command) return wrong("not a canonical command such as '1 N..... STRAIGHT_FEED(...)'");
    if (const auto reason = reader.take(*command, blocks))
      return wrong(std::string(command->name) + ": " + *reason);
  }
  if (!reader.ended()) return fail(Code::kInput, name + ": it ends without PROGRAM_END()");
  return blocks;
}

}  // namespace tiltfeed::sim
