#include "daemon/journal/reentry.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "daemon/journal/control_block.h"
#include "daemon/journal/control_entry.h"
#include "daemon/journal/in_force.h"
#include "daemon/program/block_cursor.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/numeric_block.h"
#include "daemon/program/tool_change.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

struct Survey {
  InForce before;          // the line of the first block
  std::uint64_t line = 0;  // of the file
  double highest = 0.0;    // Z of any move of the program
  std::uint64_t blocks = 0;
  std::string first;      // text of that line
  bool relative = false;  // G91 is in force before it
};

Result<Survey> survey(const std::string& path, LinkKind kind, const MachineModel& machine,
                      std::uint64_t from) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  BlockReader reader(numeric_axes(machine), !counts_numeric_blocks(kind));
  Line line;
  std::vector<NumericBlock> blocks;
  InForce now;
  Survey found;
  bool any = false;
  for (;;) {
    const Result<bool> more = program->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    blocks.clear();
    const bool relative = reader.relative();
    if (const Result<void> read = reader.read(line, blocks); !read)
      return fail(Code::kInput, path + ":" + std::to_string(line.number) + ": '" + line.text +
                                    "': " + read.error().message +
                                    "; what is in force after it is not known, so nothing can be re-entered");
    found.blocks += counts_numeric_blocks(kind) ? blocks.size() : 1;
    if (found.line == 0 && found.blocks >= from) {
      found.line = line.number;
      found.before = now;
      found.relative = relative;
      found.first = line.text;
    }
    now.take_words(line.text);
    for (const NumericBlock& block : blocks) {
      now.take(block);
      if (!states_height(block)) continue;
      const double top = block.z + block.rise;
      found.highest = any ? std::max(found.highest, top) : top;
      any = true;
    }
  }
  return found;
}

std::string without_brackets(std::string_view comment) {
  std::string kept;
  for (const char c : comment)
    if (c != '(' && c != ')' && static_cast<unsigned char>(c) >= ' ') kept += c;
  return kept;
}

/// In brackets whatever it stood in; empty where there is none.
std::string bracketed(std::string_view comment) {
  const std::string kept = without_brackets(comment);
  return kept.empty() ? "" : "(" + kept + ")";
}

/// In the head of a re-entry, for who enters that one again.
constexpr std::string_view kSpindleRemark = "TILTFEED in the spindle: ";

/// What later tool changes are named and held against: the comment of the entered line, and the newest ones
/// before it that state a tool length, and stand beside a T word. `spindle`: the tool of the head of a
/// re-entry.
struct Remarks {
  std::string length, chosen, first, spindle;
};

Result<Remarks> remarks_at(const std::string& path, std::uint64_t line) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  Remarks found;
  std::string_view raw;
  while (program->number() < line) {
    const Result<bool> more = program->read_raw(raw);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    const std::string_view comment = comment_of(raw);
    if (program->number() == line)
      found.first = bracketed(comment);
    else if (const std::size_t at = comment.find(kSpindleRemark); at != comment.npos)
      found.spindle = without_brackets(comment.substr(at + kSpindleRemark.size()));
    else if (states_length(comment))
      found.length = bracketed(comment);
    else if (raw.substr(0, raw.find_first_of("(;")).find_first_of("Tt") != raw.npos)
      found.chosen = bracketed(comment);
  }
  return found;
}

/// The steps before the first block, as program lines and in words.
class Steps {
 public:
  Steps(const config::MachineProfile& machine, Joints start) : machine_(machine), at_(start) {}

  std::string word(char letter, double value, bool rotary = false) const {
    const config::ProgramFormat& f = machine_.format;
    return std::string(" ") + letter + decimal(value, rotary ? f.rotary_decimals : f.linear_decimals);
  }
  /// Words of the rotary axes that the machine has.
  std::string turns(const Joints& at) const {
    const MachineModel& m = machine_.model;
    return (m.tilt.present ? word(m.tilt.letter, at.a, true) : "") +
           (m.rotary.present ? word(m.rotary.letter, at.c, true) : "");
  }
  void line(const std::string& text) { program += text + "\n"; }
  void say(const std::string& text, const std::string& words) {
    preview += std::to_string(++count_) + ". " + words + "\n   " + text + "\n";
    line(text);
    if (lifted && text[0] == 'G' && text[1] != '4') held += text + "\n";
  }
  /// Of a place of all axes.
  std::string place(const Joints& at) const {
    return word('X', at.x) + word('Y', at.y) + word('Z', at.z) + turns(at);
  }
  /// The move that was just said ends there. The first one that leaves the travel is kept.
  void reach(const Joints& to) {
    at_ = to;
    if (const auto broken = broken_limit(machine_.model, to); broken && limit.empty())
      limit = "step " + std::to_string(count_) + ": " + *broken;
  }
  const Joints& at() const { return at_; }

  std::string program, preview, limit;
  std::string from, held;  ///< as those of Reentry
  bool lifted = false;     ///< it is off the place where it stands

 private:
  const config::MachineProfile& machine_;
  Joints at_;
  int count_ = 0;
};

/// What the linear axes do while the tool goes back along its axis from `at`, the rotaries standing.
Joints along_axis(const config::MachineProfile& machine, const ReentryOptions& options, const Joints& at,
                  double height) {
  const Pose pose = forward(machine.model, options.setup, at);
  const Joints to = solve_linear(machine.model, options.setup, pose.tip + pose.axis * height, at.a, at.c);
  return {to.x - at.x, to.y - at.y, to.z - at.z, 0.0, 0.0};
}

void lift(Steps& steps, const Survey& found, const Joints& rise, const config::MachineProfile& machine,
          const ReentryOptions& options, bool relative) {
  const std::string feed = " F" + decimal(options.plunge_feed, 1);
  const Joints from = options.stands.value_or(found.before.joints());
  double height = options.retract;
  Joints way = along_axis(machine, options, from, height);
  const auto end = [&] { return Joints{from.x + way.x, from.y + way.y, from.z + way.z, from.a, from.c}; };
  // A machine that stands at the top of its travel, as after a parking, has not so far to go.
  while (options.stands && height > 0.0 && broken_limit(machine.model, end())) {
    height = height > kLeastRetract ? height / 2 : 0.0;
    way = along_axis(machine, options, from, height);
  }
  const Joints clear = end();
  const std::string said =
      "retract " + decimal(height, 1) + " mm along the tool axis " +
      (options.stands ? "that the machine reports, from" + steps.word('X', from.x) + steps.word('Y', from.y) +
                            steps.word('Z', from.z) + steps.turns(from)
                      : "of the block that is entered (the machine does not report its own), from where the "
                        "tool stands");
  if (height <= 0.0) {
    steps.preview += "no retract: the machine stands at the end of its travel\n";
  } else if (relative) {
    steps.line("G91");
    steps.say("G1" + steps.word('X', way.x) + steps.word('Y', way.y) + steps.word('Z', way.z) + feed,
              said + ", by these words (G91)");
    steps.line("G90");
  } else {
    steps.say("G1" + steps.word('X', clear.x) + steps.word('Y', clear.y) + steps.word('Z', clear.z) +
                  steps.turns(from) + feed,
              said);
  }
  if (height > 0.0) steps.reach(clear);
  if (options.stands) {
    // At feed: on rapids bodies are to be further apart, and the cut may have been nearer.
    steps.from = "G1" + steps.place(from) + feed + "\nG1" + steps.place(clear) + feed + "\n";
    steps.held = "G0" + steps.place(clear) + "\n";
  }
  steps.lifted = true;
  // Above any place of the program by the retract, or as high as the machine goes: never down.
  Joints top = clear;
  top.z = std::max(clear.z, std::min(found.highest + std::max(rise.z, 0.0), machine.model.z.max));
  steps.say("G0" + steps.word('Z', top.z), "up, over the highest place of the program");
  steps.reach(top);
}

/// RepRap wants the code first, and seconds as S.
void start_spindle(Steps& steps, const InForce& before, double delay, bool reprap) {
  const bool turns = before.spindle_code != 5;
  const std::string speed = "S" + decimal(before.spindle, 3),
                    code = "M" + std::to_string(before.spindle_code);
  if (turns) steps.say(reprap ? code + " " + speed : speed + " " + code, "spindle");
  if (before.mist) steps.say("M7", "mist coolant");
  if (before.flood) steps.say("M8", "flood coolant");
  if (turns) steps.say((reprap ? "G4 S" : "G4 P") + decimal(delay, 1), "until the spindle turns");
}

/// Where the block before has left an axis at a place of the machine's own: no way along the tool axis can be
/// known, so each axis goes there by itself, Z last.
void approach_by_axes(Steps& steps, const InForce& before, const config::MachineProfile& machine,
                      const ReentryOptions& options, bool reprap) {
  const auto go = [&](std::string_view letters, const char* what) {
    if (const std::string to = before.words(machine, InForce::Place::kProgram, letters); !to.empty())
      steps.say("G0" + to, std::string(what) + " as programmed");
    if (const std::string to = before.words(machine, InForce::Place::kMachine, letters); !to.empty())
      steps.say("G53 G0" + to, std::string(what) + " to the place of the machine's own");
  };
  go("R", "turn the rotary axes");
  go("XY", "X and Y");
  start_spindle(steps, before, options.spindle_delay, reprap);
  if (const std::string to = before.words(machine, InForce::Place::kProgram, "Z"); !to.empty())
    steps.say("G1" + to + " F" + decimal(options.plunge_feed, 1),
              "down to the end of the block before, at plunge feed");
  else
    go("Z", "Z");
}

void approach(Steps& steps, const InForce& before, const Joints& rise, const ReentryOptions& options,
              bool reprap) {
  const Joints at = before.joints();
  const std::string feed = " F" + decimal(options.plunge_feed, 1);
  Joints to = steps.at();
  to.a = at.a, to.c = at.c;
  const std::string turns = steps.turns(at);
  if (!turns.empty()) steps.say("G0" + turns, "turn the rotary axes as programmed, turns counted");
  steps.reach(to);
  to.x = at.x + rise.x, to.y = at.y + rise.y;
  steps.say("G0" + steps.word('X', to.x) + steps.word('Y', to.y), "X and Y over the entry");
  steps.reach(to);
  start_spindle(steps, before, options.spindle_delay, reprap);
  to.z = at.z + rise.z;
  steps.say("G1" + steps.word('Z', to.z) + feed,
            "down to " + decimal(options.retract, 1) + " mm over the entry, at plunge feed");
  steps.reach(to);
  steps.say("G1" + steps.word('X', at.x) + steps.word('Y', at.y) + steps.word('Z', at.z) + feed,
            "along the tool axis to the end of the block before, at plunge feed");
  steps.reach(at);
}

/// The tool of the newest change before the entered block; empty: there is none. Errors: those of
/// read_tool_changes.
Result<std::string> tool_before(const std::string& program, LinkKind kind, const MachineModel& machine,
                                std::uint64_t from) {
  const auto changes = read_tool_changes(program, kind, numeric_axes(machine));
  if (!changes) return tl::unexpected<Error>(changes.error());
  std::string tool;
  for (const ToolChange& change : *changes)
    if (change.block < from)
      tool = tool_text(change) + (change.length ? ", " + decimal(*change.length, 4) + " mm long" : "");
  return tool;
}

/// An arc that only goes on with G2 or G3 of a line before: the head of the program ends in G1.
bool takes_arc_over(const InForce& before, std::string_view line) {
  bool moves = false;
  while (const std::optional<GcodeWord> word = take_word(line)) {
    if (word->letter == 'G' && word->value >= 0.0 && word->value <= 3.0) return false;
    moves = moves || std::string_view("XYZIJK").find(word->letter) != std::string_view::npos;
  }
  return before.arc && moves;
}

/// What the program has said of the axes is enough to go there. Errors: kUsage.
Result<void> check_placed(const InForce& before, const MachineModel& machine, std::uint64_t from) {
  const std::string unsaid = before.letters(machine, InForce::Place::kUnsaid);
  if (unsaid.empty()) return {};
  const std::string block = "block " + std::to_string(from);
  if (unsaid == InForce().letters(machine, InForce::Place::kUnsaid))
    return fail(Code::kUsage, "no axis has moved before " + block + ": start the job instead");
  return fail(Code::kUsage, "before " + block + " the program has not said where " + unsaid +
                                (unsaid.size() == 1 ? " is" : " are") +
                                ": enter at a later block, or start the job instead");
}

/// The lines behind the head as they stand in the file.
Result<void> write_rest(LineReader& whole, std::uint64_t line, std::ostream& out) {
  for (std::string_view raw;;) {
    const Result<bool> more = whole.read_raw(raw);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return {};
    if (whole.number() > line) out << raw << '\n';
  }
}

}  // namespace

Result<Reentry> plan_reentry(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                             const ReentryOptions& options) {
  if (kind == LinkKind::kDrip && in_control_words(machine))
    return plan_control_entry(program, machine, options);
  if (options.from < 2) return fail(Code::kUsage, "block 1 needs no re-entry: start the job instead");
  Result<Survey> found = survey(program, kind, machine.model, options.from);
  if (!found) return tl::unexpected<Error>(found.error());
  if (found->line == 0)
    return fail(Code::kUsage, "block " + std::to_string(options.from) + ": the program has " +
                                  std::to_string(found->blocks));
  const InForce& before = found->before;
  if (found->relative)
    return fail(Code::kUsage, "block " + std::to_string(options.from) +
                                  " is a relative one (G91): enter at a block after the next G90");
  if (takes_arc_over(before, found->first))
    return fail(Code::kUsage,
                "block " + std::to_string(options.from) +
                    " is an arc without a G2 or G3 of its own: enter at a block that states one, "
                    "or G1");
  if (const auto placed = check_placed(before, machine.model, options.from); !placed)
    return tl::unexpected<Error>(placed.error());
  if (counts_numeric_blocks(kind) && !options.stands)
    return fail(
        Code::kUsage,
        "this controller does not report where its axes are, so that no retract can be written for it: "
        "move the tool clear by hand, and start a program of what is left");
  const bool whole = before.is_placed(machine.model), reprap = kind == LinkKind::kRepRap;
  if (!whole && !options.stands)
    return fail(Code::kUsage,
                "before block " + std::to_string(options.from) +
                    " the program stands at a place of the machine's own (G53), and the machine "
                    "does not report where it is now: enter at another block");
  // Where no axis of a tool is known, the height alone: over the highest place of the program.
  const Joints rise = whole ? along_axis(machine, options, before.joints(), options.retract)
                            : Joints{0, 0, options.retract, 0, 0};
  Steps steps(machine, before.joints());
  steps.line("(TILTFEED re-entry before block " + std::to_string(options.from) + ", line " +
             std::to_string(found->line) + ")");
  const Result<Remarks> remarks = remarks_at(program, found->line);
  if (!remarks) return tl::unexpected<Error>(remarks.error());
  // Without a change before it the tool is the one that the program, or the entry that it is, began with.
  Result<std::string> tool = tool_before(program, kind, machine.model, options.from);
  if (tool && tool->empty()) *tool = remarks->spindle;
  if (!tool)
    steps.preview = "0. which tool must be in the spindle is not known: " + tool.error().message + "\n";
  else if (!tool->empty())
    steps.preview = "0. in the spindle must be: " + *tool + "\n";
  if (tool && !tool->empty()) steps.line(bracketed(std::string(kSpindleRemark) + *tool));
  if (reprap)
    for (const char* mode : {"G21", "G90", "G94"}) steps.line(mode);  // it takes one code a line
  else
    steps.line("G21 G90 G17 G40 G49 G54 G94");
  lift(steps, *found, rise, machine, options, !counts_numeric_blocks(kind));
  if (whole)
    approach(steps, before, rise, options, reprap);
  else
    approach_by_axes(steps, before, machine, options, reprap);
  if (!steps.limit.empty())
    return fail(Code::kLimit, "re-entry before block " + std::to_string(options.from) + ", " + steps.limit +
                                  "; enter at another block");
  for (const std::string& mode : before.mode_lines(options.plunge_feed)) steps.line(mode);
  if (!remarks->length.empty()) steps.line(remarks->length);
  if (before.chosen)
    steps.line("T" + std::to_string(*before.chosen) + remarks->chosen);  // for an M6 that comes later
  steps.preview += "then block " + std::to_string(options.from) + ", line " + std::to_string(found->line) +
                   ": " + found->first + "\n";
  steps.line(found->first + remarks->first);
  return Reentry{std::move(steps.program), std::move(steps.preview), found->line,
                 std::move(steps.from),    std::move(steps.held),    false};
}

Result<void> write_reentry(const std::string& program, const Reentry& entry, std::ostream& out) {
  Result<LineReader> lines = LineReader::open(program), whole = LineReader::open(program);
  if (!lines) return tl::unexpected<Error>(lines.error());
  if (!whole) return tl::unexpected<Error>(whole.error());
  out << entry.head;
  if (entry.as_it_stands) return write_rest(*whole, entry.line, out);
  Line line;
  std::string_view raw;
  for (;;) {
    const Result<bool> more = lines->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return {};
    // The lines without words before it, too: their comments say of which length the next tool is.
    while (whole->number() < line.number) {
      const Result<bool> read = whole->read_raw(raw);
      if (!read) return tl::unexpected<Error>(read.error());
      if (!*read) return fail(Code::kIo, program + ": was changed while it was read");
      if (whole->number() <= entry.line) continue;
      const bool sent = whole->number() == line.number;
      const std::string comment = bracketed(comment_of(raw));
      if (sent || !comment.empty()) out << (sent ? line.text : "") << comment << '\n';
    }
  }
}

}  // namespace tiltfeed::daemon
