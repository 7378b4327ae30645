#include "daemon/journal/tool_return.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "daemon/journal/in_force.h"
#include "daemon/program/block_cursor.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/numeric_block.h"
#include "daemon/program/tool_change.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

/// The program before the tool change.
struct Before {
  InForce now;
  std::optional<double> highest;  ///< Z of its moves, mm
};

Result<Before> read_before(const std::string& path, LinkKind kind, const MachineModel& machine,
                           std::uint64_t change) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  BlockReader reader(numeric_axes(machine), !counts_numeric_blocks(kind));
  Before found;
  InForce& now = found.now;
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
    for (const NumericBlock& block : blocks) {
      now.take(block);
      if (states_height(block)) found.highest = std::max(found.highest.value_or(block.z), block.z);
    }
  }
  return found;
}

class WayWriter {
 public:
  explicit WayWriter(const config::MachineProfile& machine) : machine_(machine) {}
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
void start_spindle(WayWriter& way, const InForce& before, double delay, bool reprap) {
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

/// The profile's line that takes the tool off along the machine's Z. Errors: kUsage where it states none.
Result<std::string> retract_line(const config::ProgramFormat& format) {
  if (format.retract == "none")
    return fail(Code::kUsage,
                "the profile states no retract line (program.retract: none); move the tool off by hand");
  const bool usual = format.retract.empty() || format.retract == "default";
  return usual ? std::string("G53 G0 Z0") : format.retract;
}

/// The program words of the axes of `letters` first, then those of places of the machine's own. `known`: a
/// line that has been there already.
void go(WayWriter& way, const InForce& before, const config::MachineProfile& machine,
        std::string_view letters, const std::string& what, const std::string& known = "") {
  if (const std::string to = before.words(machine, InForce::Place::kProgram, letters); !to.empty())
    way.step("G0" + to, what);
  const std::string own = before.words(machine, InForce::Place::kMachine, letters), text = "G53 G0" + own;
  if (!own.empty() && text != known)
    way.step(text, "to the place of the machine's own where the program stands");
}

/// Down to where the program stands, as far as it has said.
void descend(WayWriter& way, const InForce& before, const config::MachineProfile& machine,
             const ReturnOptions& options, const Joints& high, std::optional<double> highest,
             const std::string& up) {
  const std::string feed = " F" + decimal(options.plunge_feed, 1);
  const Joints at = before.joints();
  if (before.is_placed(machine.model)) {
    if (const double clear = highest.value_or(high.z) + options.retract;
        clear > high.z + kLeastRetract && clear < machine.model.z.max)
      way.step("G0" + way.word('Z', clear),
               "down to " + decimal(options.retract, 1) + " mm over the highest place of the program so far");
    way.step("G1" + way.word('Z', high.z) + feed,
             "down to " + decimal(options.retract, 1) + " mm over it, at plunge feed");
    way.reach(high);
    way.step("G1" + way.word('X', at.x) + way.word('Y', at.y) + way.word('Z', at.z) + feed,
             "along the tool axis to the end of the block before the tool change, at plunge feed");
    way.reach(at);
  } else if (!before.letters(machine.model, InForce::Place::kUnsaid).empty()) {
    way.found.preview +=
        "The other axes stay where they are: the program has not said where they are by then.\n";
  } else if (const std::string z = before.words(machine, InForce::Place::kProgram, "Z"); !z.empty()) {
    way.step("G1" + z + feed, "down to the end of the block before the tool change, at plunge feed");
  } else {
    go(way, before, machine, "Z", "", up);
  }
}

}  // namespace

Result<ToolWay> plan_park(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                          const ReturnOptions& options) {
  const Result<std::string> up = retract_line(machine.format);
  if (!up) return tl::unexpected<Error>(up.error());
  const Result<Before> found = read_before(program, kind, machine.model, options.change);
  if (!found) return tl::unexpected<Error>(found.error());
  const InForce& before = found->now;
  WayWriter way(machine);
  for (const char* mode : {"G21", "G90", "G94"}) way.line(mode);
  const Joints at = before.joints();
  for (double height = options.retract; before.is_placed(machine.model) && height > kLeastRetract;
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
  const Result<Before> found = read_before(program, kind, machine.model, options.change);
  if (!found) return tl::unexpected<Error>(found.error());
  const InForce& before = found->now;
  WayWriter way(machine);
  for (const char* mode : {"G21", "G90", "G94"}) way.line(mode);  // RepRap: one a line
  way.step(*up, "up, the profile's retract line");
  InForce over_it = before;  // X and Y where the tool is clear
  const Joints at = before.joints();
  const Joints high =
      before.is_placed(machine.model) ? over(machine.model, options, at, options.retract) : at;
  over_it.at[0] = high.x, over_it.at[1] = high.y;
  go(way, before, machine, "R", "turn the rotary axes as programmed, turns counted");
  go(way, over_it, machine, "XY", "X and Y over the place where the program stands");
  start_spindle(way, before, options.spindle_delay, kind == LinkKind::kRepRap);
  descend(way, before, machine, options, high, found->highest, *up);
  if (!way.limit.empty()) return fail(Code::kLimit, way.limit);
  if (!counts_numeric_blocks(kind))
    for (const std::string& mode : before.mode_lines(options.plunge_feed)) way.line(mode);
  return std::move(way.found);
}

}  // namespace tiltfeed::daemon
