#include "daemon/journal/reentry.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "daemon/program/block_cursor.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/numeric_block.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

constexpr double kLeastRetract = 1.0;  // mm: less is not worth a move

/// What is in force before a line, gathered from the program's start.
struct InForce {
  Joints at;
  bool placed = false, inverse_time = false, rapid = true;
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
    if (b.machine) return;  // where that is in the part's coordinates, nobody says
    at = {b.x, b.y, b.z, b.tilt, b.rotary};
    placed = b.kept == 0;
  }
  /// Modes by their words: a line may state one long before a move uses it.
  void take_words(std::string_view line) {
    while (const std::optional<GcodeWord> word = take_word(line)) {
      if (word->letter == 'F') feed = word->value;
      if (word->letter != 'G') continue;
      if (word->value == 0.0 || word->value == 1.0) rapid = word->value == 0.0;
      if (word->value != 93.0 && word->value != 94.0) continue;
      if (inverse_time != (word->value == 93.0)) feed = 0.0;  // F means another thing now
      inverse_time = word->value == 93.0;
    }
  }
};

struct Survey {
  InForce before;          // the line of the first block
  std::uint64_t line = 0;  // of the file
  double highest = 0.0;    // Z of any move of the program
  std::uint64_t blocks = 0;
  std::string first;  // text of that line
};

Result<Survey> survey(const std::string& path, LinkKind kind, const MachineModel& machine,
                      std::uint64_t from) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  BlockReader reader(numeric_axes(machine));
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
    if (const Result<void> read = reader.read(line, blocks); !read)
      return fail(Code::kInput, path + ":" + std::to_string(line.number) + ": '" + line.text +
                                    "': " + read.error().message +
                                    "; what is in force after it is not known, so nothing can be re-entered");
    found.blocks += counts_numeric_blocks(kind) ? blocks.size() : 1;
    if (found.line == 0 && found.blocks >= from) {
      found.line = line.number;
      found.before = now;
      found.first = line.text;
    }
    now.take_words(line.text);
    for (const NumericBlock& block : blocks) {
      now.take(block);
      if (block.op != BlockOp::kRapid && block.op != BlockOp::kFeed) continue;
      if (block.machine || (block.kept & 4) != 0) continue;
      found.highest = any ? std::max(found.highest, block.z) : block.z;
      any = true;
    }
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
  }
  /// The move that was just said ends there. The first one that leaves the travel is kept.
  void reach(const Joints& to) {
    at_ = to;
    if (const auto broken = broken_limit(machine_.model, to); broken && limit.empty())
      limit = "step " + std::to_string(count_) + ": " + *broken;
  }
  const Joints& at() const { return at_; }

  std::string program, preview, limit;

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
  const Joints from = options.stands.value_or(found.before.at);
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
    steps.say("G1" + steps.word('X', way.x) + steps.word('Y', way.y) + steps.word('Z', way.z) + feed, said);
    steps.line("G90");
  } else {
    steps.say("G1" + steps.word('X', clear.x) + steps.word('Y', clear.y) + steps.word('Z', clear.z) +
                  steps.turns(from) + feed,
              said);
  }
  if (height > 0.0) steps.reach(clear);
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

void approach(Steps& steps, const InForce& before, const Joints& rise, const ReentryOptions& options,
              bool reprap) {
  const Joints& at = before.at;
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

bool states_motion(const std::string& line) {
  std::string_view rest = line;
  while (const std::optional<GcodeWord> word = take_word(rest))
    if (word->letter == 'G' && (word->value == 0.0 || word->value == 1.0 || word->value == 4.0)) return true;
  return false;
}

}  // namespace

Result<Reentry> plan_reentry(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                             const ReentryOptions& options) {
  if (options.from < 2) return fail(Code::kUsage, "block 1 needs no re-entry: start the job instead");
  Result<Survey> found = survey(program, kind, machine.model, options.from);
  if (!found) return tl::unexpected<Error>(found.error());
  if (found->line == 0)
    return fail(Code::kUsage, "block " + std::to_string(options.from) + ": the program has " +
                                  std::to_string(found->blocks));
  const InForce& before = found->before;
  if (!before.placed)
    return fail(Code::kUsage,
                "no axis has moved before block " + std::to_string(options.from) + ": start the job instead");

  if (counts_numeric_blocks(kind) && !options.stands)
    return fail(
        Code::kUsage,
        "this controller does not report where its axes are, so that no retract can be written for it: "
        "move the tool clear by hand, and start a program of what is left");
  const Joints rise = along_axis(machine, options, before.at, options.retract);
  Steps steps(machine, before.at);
  steps.line("(TILTFEED re-entry before block " + std::to_string(options.from) + ", line " +
             std::to_string(found->line) + ")");
  if (kind == LinkKind::kRepRap)
    for (const char* mode : {"G21", "G90", "G94"}) steps.line(mode);  // it takes one code a line
  else
    steps.line("G21 G90 G17 G40 G49 G54 G94");
  lift(steps, *found, rise, machine, options, !counts_numeric_blocks(kind));
  approach(steps, before, rise, options, kind == LinkKind::kRepRap);
  if (!steps.limit.empty())
    return fail(Code::kLimit, "re-entry before block " + std::to_string(options.from) + ", " + steps.limit +
                                  "; choose a shorter --retract or another block");
  steps.line(before.inverse_time ? "G93" : "G94" + (before.feed > 0.0 ? " F" + decimal(before.feed, 4) : ""));
  std::string first = found->first;
  if (!states_motion(first)) first = (before.rapid ? "G0" : "G1") + first;
  steps.preview += "then block " + std::to_string(options.from) + ", line " + std::to_string(found->line) +
                   ": " + first + "\n";
  steps.line(first);
  return Reentry{std::move(steps.program), std::move(steps.preview), found->line};
}

Result<void> write_reentry(const std::string& program, const Reentry& entry, std::ostream& out) {
  Result<LineReader> whole = LineReader::open(program);
  if (!whole) return tl::unexpected<Error>(whole.error());
  out << entry.head;
  Line line;
  for (;;) {
    const Result<bool> more = whole->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return {};
    if (line.number > entry.line) out << line.text << '\n';
  }
}

}  // namespace tiltfeed::daemon
