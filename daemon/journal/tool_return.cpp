#include "daemon/journal/tool_return.h"

#include <optional>
#include <vector>

#include "daemon/program/block_cursor.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/numeric_block.h"
#include "daemon/program/tool_change.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

constexpr int kAxes = 5;
constexpr double kLeastRetract = 1.0;  // mm: less is not worth a move

/// What is in force before the change, gathered from the program's start.
struct InForce {
  double at[kAxes] = {};    // X Y Z tilt rotary
  bool stated[kAxes] = {};  // in program coordinates
  bool inverse_time = false, rapid = true;
  double feed = 0.0, spindle = 0.0;
  int spindle_code = 5;
  bool mist = false, flood = false;

  void take(const NumericBlock& b) {
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
      if ((b.kept >> i & 1) != 0) continue;
      stated[i] = !b.machine;
      at[i] = to[i];
    }
  }
  /// Modes by their words: a line may state one long before a move uses it.
  void take_words(std::string_view line) {
    while (const std::optional<GcodeWord> word = take_word(line)) {
      if (word->letter == 'F') feed = word->value;
      if (word->letter != 'G') continue;
      if (word->value >= 0.0 && word->value <= 3.0) rapid = word->value == 0.0;
      if (word->value != 93.0 && word->value != 94.0) continue;
      if (inverse_time != (word->value == 93.0)) feed = 0.0;  // F means another thing now
      inverse_time = word->value == 93.0;
    }
  }
  Joints joints() const { return {at[0], at[1], at[2], at[3], at[4]}; }
};

Result<InForce> in_force_before(const std::string& path, LinkKind kind, const MachineModel& machine,
                                std::uint64_t change) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  BlockReader reader(numeric_axes(machine));
  InForce now;
  Line line;
  std::vector<NumericBlock> blocks;
  const bool by_line = !counts_numeric_blocks(kind);
  for (std::uint64_t count = 1; count < change;) {
    const Result<bool> more = program->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    blocks.clear();
    now.take_words(line.text);
    if (by_line) line.text = straightened(line.text);
    if (const Result<void> read = reader.read(line, blocks); !read && by_line)
      blocks.clear();  // it stands before the first motion: read_tool_changes() has seen to that
    else if (!read)
      return fail(Code::kInput, path + ":" + std::to_string(line.number) + ": '" + line.text +
                                    "': " + read.error().message);
    count += by_line ? 1 : blocks.size();
    for (const NumericBlock& block : blocks) now.take(block);
  }
  return now;
}

class Way {
 public:
  explicit Way(const config::MachineProfile& machine) : machine_(machine) {}
  std::string word(char letter, double value, bool rotary = false) const {
    const config::ProgramFormat& f = machine_.format;
    return std::string(" ") + letter + decimal(value, rotary ? f.rotary_decimals : f.linear_decimals);
  }
  /// A feed of all axes.
  std::string all(const Joints& to) const {
    const MachineModel& m = machine_.model;
    return "G1" + word('X', to.x) + word('Y', to.y) + word('Z', to.z) +
           (m.tilt.present ? word(m.tilt.letter, to.a, true) : "") +
           (m.rotary.present ? word(m.rotary.letter, to.c, true) : "");
  }
  void line(const std::string& text) { found.program += text + "\n"; }
  void step(const std::string& text, const std::string& words) {
    found.preview += std::to_string(++count_) + ". " + words + "\n   " + text + "\n";
    line(text);
  }
  /// A move that was just said ends there: the first that leaves the travel is kept.
  void reach(const Joints& to) {
    if (const auto broken = broken_limit(machine_.model, to); broken && limit.empty())
      limit = "step " + std::to_string(count_) + " of the way back: " + *broken;
  }

  ToolWay found;
  std::string limit;

 private:
  const config::MachineProfile& machine_;
  int count_ = 0;
};

/// RepRap wants the code first, and seconds as S.
void start_spindle(Way& way, const InForce& before, double delay, bool reprap) {
  const bool turns = before.spindle_code != 5;
  if (turns)
    way.step("M" + std::to_string(before.spindle_code) + " S" + decimal(before.spindle, 3), "spindle");
  if (before.mist) way.step("M7", "mist coolant");
  if (before.flood) way.step("M8", "flood coolant");
  if (turns) way.step((reprap ? "G4 S" : "G4 P") + decimal(delay, 1), "until the spindle turns");
}

/// The tip `height` up its axis, the rotaries standing.
Joints over(const MachineModel& machine, const ReturnOptions& options, const Joints& at, double height) {
  const Pose pose = forward(machine, options.setup, at);
  return solve_linear(machine, options.setup, pose.tip + pose.axis * height, at.a, at.c);
}

/// As they were: the next line may count on them.
void add_modes(Way& way, const InForce& before) {
  const std::string feed = before.feed > 0.0 ? " F" + decimal(before.feed, 4) : "";
  way.line(before.inverse_time ? "G93" : "G94");
  if (before.rapid || feed.empty())
    way.line("G0" + (before.inverse_time ? "" : feed));
  else
    way.line("G1" + feed);
}

/// The profile's line that takes the tool off along the machine's Z. Errors: kUsage where it states none.
Result<std::string> retract_line(const config::ProgramFormat& format) {
  if (format.retract == "none")
    return fail(Code::kUsage, "the profile states no retract line (program.retract: none); jog the tool off");
  const bool usual = format.retract.empty() || format.retract == "default";
  return usual ? std::string("G53 G0 Z0") : format.retract;
}

/// All axes that the machine has stand where the program has said.
bool is_placed(const MachineModel& model, const InForce& now) {
  return now.stated[0] && now.stated[1] && now.stated[2] && (!model.tilt.present || now.stated[3]) &&
         (!model.rotary.present || now.stated[4]);
}

}  // namespace

Result<ToolWay> plan_park(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                          const ReturnOptions& options) {
  const Result<std::string> up = retract_line(machine.format);
  if (!up) return tl::unexpected<Error>(up.error());
  const Result<InForce> before = in_force_before(program, kind, machine.model, options.change);
  if (!before) return tl::unexpected<Error>(before.error());
  Way way(machine);
  for (const char* mode : {"G21", "G90", "G94"}) way.line(mode);
  const Joints at = before->joints();
  for (double height = options.retract; is_placed(machine.model, *before) && height > kLeastRetract;
       height /= 2) {
    const Joints high = over(machine.model, options, at, height);
    if (broken_limit(machine.model, high)) continue;
    way.step(way.all(high) + " F" + decimal(options.plunge_feed, 1), "off along the tool axis");
    break;
  }
  way.step("M5", "spindle off");
  way.step("M9", "coolant off");
  way.step(*up, "up, the profile's retract line");
  return std::move(way.found);
}

Result<ToolWay> plan_return(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                            const ReturnOptions& options) {
  const Result<std::string> up = retract_line(machine.format);
  if (!up) return tl::unexpected<Error>(up.error());
  const Result<InForce> before = in_force_before(program, kind, machine.model, options.change);
  if (!before) return tl::unexpected<Error>(before.error());
  const MachineModel& model = machine.model;
  Way way(machine);
  for (const char* mode : {"G21", "G90", "G94"}) way.line(mode);  // RepRap: one a line
  way.step(*up, "up, the profile's retract line");
  const bool whole = is_placed(model, *before);
  const Joints at = before->joints();
  const Joints high = whole ? over(model, options, at, options.retract) : at;
  std::string turns;
  if (model.tilt.present && before->stated[3]) turns += way.word(model.tilt.letter, at.a, true);
  if (model.rotary.present && before->stated[4]) turns += way.word(model.rotary.letter, at.c, true);
  if (!turns.empty()) way.step("G0" + turns, "turn the rotary axes as programmed, turns counted");
  std::string plane;
  if (before->stated[0]) plane += way.word('X', high.x);
  if (before->stated[1]) plane += way.word('Y', high.y);
  if (!plane.empty()) way.step("G0" + plane, "X and Y over the place where the program stands");
  start_spindle(way, *before, options.spindle_delay, kind == LinkKind::kRepRap);
  const std::string feed = " F" + decimal(options.plunge_feed, 1);
  if (whole) {
    way.step("G1" + way.word('Z', high.z) + feed,
             "down to " + decimal(options.retract, 1) + " mm over it, at plunge feed");
    way.reach(high);
    way.step("G1" + way.word('X', at.x) + way.word('Y', at.y) + way.word('Z', at.z) + feed,
             "along the tool axis to the end of the block before the tool change, at plunge feed");
    way.reach(at);
  } else {
    way.found.preview +=
        "The other axes stay where they are: the program has not said where they are by then.\n";
  }
  if (!way.limit.empty()) return fail(Code::kLimit, way.limit);
  if (!counts_numeric_blocks(kind)) add_modes(way, *before);
  return std::move(way.found);
}

}  // namespace tiltfeed::daemon
