#include "daemon/journal/control_entry.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include "daemon/journal/control_block.h"
#include "daemon/journal/control_state.h"
#include "daemon/journal/in_force.h"
#include "daemon/post/block.h"
#include "daemon/post/dialect.h"
#include "daemon/post/nc_lines.h"
#include "daemon/post/nc_reader.h"
#include "daemon/post/nc_rules.h"
#include "daemon/post/printed_path.h"
#include "daemon/post/tcp_start.h"
#include "daemon/post/unpost.h"
#include "daemon/program/line_reader.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/timing/tcp_path.h"

namespace tiltfeed::daemon {

namespace {

/// A plane whose directions or origin differ by more is another, mm and as a chord.
constexpr double kSamePlane = 1e-9;

/// A place of the program's text.
struct At {
  std::size_t operation = 0, block = 0;
};

/// The program up to the entry.
struct Found {
  NcProgram text;
  ControlState state;               ///< before the entry
  At before;                        ///< the block whose end is come to
  std::uint64_t line = 0;           ///< of the entry, in the file
  std::string entry;                ///< that line as it stands
  std::vector<std::string> header;  ///< lines in front of the first words
};

const TextBlock& block_at(const NcProgram& text, const At& at) {
  return text.operations[at.operation].blocks[at.block];
}

std::string block_text(std::uint64_t number) { return "block " + std::to_string(number); }

Result<NcProgram> text_of(const std::string& path, const config::MachineProfile& machine) {
  std::ifstream in(path);
  if (!in) return fail(Code::kIo, path + ": cannot be read");
  Result<NcProgram> text = read_nc_program(in, path, text_language(machine));
  if (text) return text;
  return fail(
      text.error().code,
      text.error().message + "; what is in force after it is not known, so nothing can be re-entered");
}

/// The first block behind a line of the file; nothing: there is none.
std::optional<At> block_behind(const NcProgram& text, std::uint64_t line) {
  for (std::size_t i = 0; i < text.operations.size(); ++i) {
    const std::vector<TextBlock>& blocks = text.operations[i].blocks;
    const auto at =
        std::find_if(blocks.begin(), blocks.end(), [&](const TextBlock& block) { return block.line > line; });
    if (at != blocks.end()) return At{i, static_cast<std::size_t>(at - blocks.begin())};
  }
  return std::nullopt;
}

/// Reads the lines before the entry, block by block.
Result<void> follow(const std::string& path, Found& found, config::Dialect dialect) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  At next;
  bool in_header = true;
  std::string_view raw;
  while (program->number() < found.line) {
    const Result<bool> more = program->read_raw(raw);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    if (program->number() == found.line) {
      found.entry = raw;
      break;
    }
    std::string words(raw);
    std::vector<std::string> comments;
    const bool plain = strip_line(words, dialect, comments) || words.empty() || words[0] == '%' ||
                       (words[0] == 'O' && words.find_first_not_of("0123456789", 1) == words.npos);
    in_header = in_header && plain;
    if (in_header) found.header.emplace_back(raw);
    found.state.take(raw);
    while (next.operation < found.text.operations.size()) {
      const std::vector<TextBlock>& blocks = found.text.operations[next.operation].blocks;
      if (next.block == blocks.size()) {
        next = {next.operation + 1, 0};
        continue;
      }
      if (blocks[next.block].line > program->number()) break;
      found.before = next;
      found.state.moved();
      ++next.block;
    }
  }
  return {};
}

/// Of each operation, as the program's header or a job states it. Errors: kInput: nobody states that of the
/// entry, and it matters.
Result<std::vector<Setup>> setups_of(const Found& found, const Setup& stated, const std::string& path) {
  Setup setup = stated;
  bool length = stated.tool_length > 0.0, zero = length;
  std::vector<Setup> setups;
  const TextBlock& block = block_at(found.text, found.before);
  for (const TextOperation& op : found.text.operations) {
    if (op.tool_length) setup.tool_length = *op.tool_length, length = true;
    if (op.part_zero) setup.part_zero = *op.part_zero, zero = true, setup.fixture = {};
    if (op.fixture_deg) setup.fixture = fixture_of(*op.fixture_deg);
    const bool of_entry = setups.size() == found.before.operation;
    if (of_entry && (block.tcp || block.plane != 0) && !(length && zero))
      return fail(Code::kInput, path + ": neither its header nor a job states " +
                                    (length ? "where part zero is" : "the tool's length") +
                                    ", and it is under TCP or in a tilted plane: where the slides stand is "
                                    "not known, so nothing can be re-entered");
    setups.push_back(setup);
  }
  return setups;
}

/// Makes the way in.
class WayIn {
 public:
  WayIn(const Found& found, const config::MachineProfile& machine, const ReentryOptions& options,
        const std::vector<Setup>& setups)
      : found_(found),
        machine_(machine),
        options_(options),
        setups_(setups),
        setup_(setups[found.before.operation]),
        before_(block_at(found.text, found.before)) {
    config::ProgramFormat& format = machine_.format;
    const bool plane = before_.plane != 0;
    if (plane) format = config::in_tilted_planes(format);
    format.tcp = before_.tcp;
    format.tilted_planes = plane;
    format.linear_decimals = std::max(format.linear_decimals, found.state.linear_decimals);
    format.rotary_decimals = std::max(format.rotary_decimals, found.state.rotary_decimals);
    format.clamp_tilt = format.clamp_rotary = "";  // where the entry wants them
    if (!found.state.smoothing.empty()) format.start.push_back(found.state.smoothing);
  }

  /// Its lines, the last of which is the last block's.
  Result<std::vector<std::string>> lines();
  double height() const { return height_; }
  /// How far it is below `retract` over the highest place, mm.
  double short_of() const { return wanted_ - height_; }

 private:
  Pose pose(const TextBlock& block, const Joints& words) const {
    return commanded_pose(machine_.model, setup_, found_.text.planes, block, words);
  }
  /// The words of a place over the entry.
  Joints over(double height) const;
  /// Where the axes stand there.
  Joints axes(const Joints& words) const;
  double highest() const;
  double within_travel(double height) const;
  Result<Posting> posting();

  const Found& found_;
  config::MachineProfile machine_;
  const ReentryOptions& options_;
  const std::vector<Setup>& setups_;
  const Setup& setup_;
  const TextBlock& before_;
  JointPath words_;
  double wanted_ = 0.0, height_ = 0.0;
};

Joints WayIn::over(double height) const {
  const Joints& at = before_.words;
  if (before_.plane != 0) return {at.x, at.y, at.z + height, at.a, at.c};
  const Pose pose = this->pose(before_, at);
  const Point<Part> tip = pose.tip + pose.axis * height;
  if (!before_.tcp) return solve_linear(machine_.model, setup_, tip, at.a, at.c);
  const Vec3 words = setup_.fixture * from_origin(tip);
  return {words.x, words.y, words.z, at.a, at.c};
}

Joints WayIn::axes(const Joints& words) const {
  const Pose at = pose(before_, words);
  return solve_linear(machine_.model, setup_, at.tip, words.a, words.c);
}

/// How far the highest place of the program is over the entry, along the tool axis there; an arc may bulge.
double WayIn::highest() const {
  const Pose entry = pose(before_, before_.words);
  double most = 0.0;
  for (std::size_t i = 0; i < found_.text.operations.size(); ++i)
    for (const TextBlock& block : found_.text.operations[i].blocks) {
      const Pose at = commanded_pose(machine_.model, setups_[i], found_.text.planes, block, block.words);
      double up = dot(at.tip - entry.tip, entry.axis);
      if (block.arc != 0) {
        const TextArc& arc = found_.text.arcs[block.arc - 1];
        const double to[3]{block.words.x, block.words.y, block.words.z};
        const int first = arc.plane == 18 ? 2 : arc.plane == 19 ? 1 : 0;
        up += 2.0 * std::hypot(to[first] - arc.first, to[(first + 1) % 3] - arc.second);
      }
      if (!block.rapid) most = std::max(most, up);
    }
  return most;
}

/// The most of `height` at which no axis is beyond its travel; the slides go evenly along the axis.
double WayIn::within_travel(double height) const {
  const auto fits = [&](double h) { return !broken_limit(machine_.model, axes(over(h))); };
  if (fits(height)) return height;
  double low = 0.0, high = height;
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (fits(middle) ? low : high) = middle;
  }
  // Rounded words are not over an end of the travel.
  return std::max(0.0, low - kLeastRetract);
}

Result<Posting> WayIn::posting() {
  wanted_ = highest() + options_.retract;
  height_ = within_travel(wanted_);
  const std::string block = block_text(options_.from);
  if (const auto broken = broken_limit(machine_.model, axes(before_.words)))
    return fail(Code::kLimit, "re-entry before " + block + ": " + *broken + "; enter at another block");
  // A rapid ends over what is cut, not on it.
  if (height_ < kLeastRetract && !before_.rapid)
    return fail(Code::kLimit,
                "re-entry before " + block +
                    ": there is no way to it along the tool axis, as an axis's travel ends there; "
                    "enter at another block");
  words_.moves.push_back({over(height_), 0.0, MoveKind::kRapid, 0});
  if (height_ > 0.0)
    words_.moves.push_back({before_.words, 60.0 * height_ / options_.plunge_feed, MoveKind::kPlunge, 1});
  words_ = printed_path(std::move(words_), machine_.format);
  const TextOperation& text = found_.text.operations[found_.before.operation];
  Operation op;
  op.words = &words_;
  op.setup = setup_;
  op.tool.length = setup_.tool_length;
  // An operation that changes no tool goes on with that of the one before.
  for (std::size_t i = found_.before.operation + 1; i > 0 && !op.tool_number; --i)
    op.tool_number = found_.text.operations[i - 1].tool_number;
  op.length_register = text.length_register;
  op.cut_feed = op.plunge_feed = Feed::from_mm_per_min(options_.plunge_feed);
  const ControlState& state = found_.state;
  if (state.turn != 0)
    op.events.push_back({0, EventKind::kSpindle, state.turn == 4 ? -state.speed : state.speed, ""});
  for (const double kind : state.coolants) op.events.push_back({0, EventKind::kCoolant, kind, ""});
  if (state.turn != 0) op.events.push_back({0, EventKind::kDwell, options_.spindle_delay, ""});
  if (before_.plane != 0) {
    op.plane = tilted_plane(machine_, before_.words.a, before_.words.c);
    const TextPlane& stated = found_.text.planes[before_.plane - 1];
    double off = length(stated.origin);
    for (std::size_t i = 0; stated.frame && i < 3; ++i)
      off = std::max(off, length(stated.frame->rows[i] - op.plane->frame.rows[i]));
    if (off > kSamePlane)
      return fail(Code::kInput, "line " + std::to_string(before_.line) +
                                    " is in a tilted plane with another origin or other angles than its "
                                    "rotaries have about part zero: such a plane is not written again");
  }
  Posting posting{found_.text.name, machine_, {}, {op}};
  const config::Dialect dialect = machine_.format.dialect;
  for (int offset = 1; offset <= config::most_work_offsets(dialect); ++offset)
    if (work_offset_word(dialect, offset) == state.offset) posting.data.work_offset = offset;
  if (work_offset_word(dialect, posting.data.work_offset) != state.offset)
    return fail(Code::kInput, "the program calls no work offset before " + block +
                                  ": which one is in force is not known, so nothing can be re-entered");
  return posting;
}

/// Whether the reader comes to the end of the block before by this text.
bool ends_there(const NcProgram& way, const NcProgram& program, const TextBlock& before) {
  const TextBlock& last = way.operations.back().blocks.back();
  const auto frame = [](const NcProgram& text, const TextBlock& block) {
    return block.plane != 0 ? text.planes[block.plane - 1].frame : std::nullopt;
  };
  return last.words == before.words && last.tcp == before.tcp && (last.plane == 0) == (before.plane == 0) &&
         frame(way, last) == frame(program, before);
}

Result<std::vector<std::string>> WayIn::lines() {
  const Result<Posting> posting = this->posting();
  if (!posting) return tl::unexpected<Error>(posting.error());
  std::ostringstream out;
  if (const auto written = write_program(*posting, out); !written)
    return tl::unexpected<Error>(written.error());
  std::istringstream in(out.str());
  const Result<NcProgram> back = read_nc_program(in, "the way in", text_language(machine_));
  if (!back) return tl::unexpected<Error>(back.error());
  if (!ends_there(*back, found_.text, before_))
    return fail(Code::kInput, "the way in does not end where " + block_text(options_.from) +
                                  " begins, when it is read back: nothing can be re-entered there");
  const std::uint32_t last = back->operations.back().blocks.back().line;
  std::vector<std::string> lines;
  std::istringstream again(out.str());
  std::string line;
  for (std::uint32_t number = 1; number <= last && std::getline(again, line); ++number) {
    std::string words = line;
    std::vector<std::string> comments;
    if (strip_line(words, machine_.format.dialect, comments) || words.empty()) continue;
    // The header is the program's own.
    const bool head = words[0] == '%' || (words[0] == 'O' && lines.empty());
    if (!head) lines.push_back(line);
  }
  return lines;
}

/// An arc that only goes on with G2 or G3 of a line before.
bool goes_on_with_arc(const Found& found, config::Dialect dialect) {
  std::string line = found.entry;
  std::vector<std::string> comments;
  DialectWords words;
  if (found.state.motion < 2 || strip_line(line, dialect, comments) || split_words(line, words)) return false;
  const bool own = words.has_g(0) || words.has_g(10) || words.has_g(20) || words.has_g(30);
  return !own && (words.has('X') || words.has('Y') || words.has('Z'));
}

/// The block can be entered as it is. Errors: kUsage.
Result<void> check_entry(const std::string& path, const Found& found, const config::MachineProfile& machine,
                         std::uint64_t from) {
  const std::string block = block_text(from);
  const ControlState& state = found.state;
  if (const bool begun = block_at(found.text, {0, 0}).line < found.line; !begun || state.away) {
    const auto next = block_behind(found.text, found.line - 1);
    if (!next) return fail(Code::kUsage, block + " is behind the last cut: the program only ends there");
    const auto behind = find_control_line(path, from, block_at(found.text, *next).line);
    if (!behind) return tl::unexpected<Error>(behind.error());
    return fail(Code::kUsage, block + " is on the way from the retract to " +
                                  (begun ? "the next" : "the first") +
                                  " place, which the way in goes by itself: enter at block " +
                                  std::to_string(behind->next) + (begun ? "" : ", or start the job instead"));
  }
  if (state.compensated)
    return fail(Code::kUsage, "before " + block +
                                  " the control shifts the tool to a side (G41 or G42): enter at a block "
                                  "behind the next G40");
  if (state.incremental)
    return fail(Code::kUsage, block + " is a relative one (G91): enter at a block after the next G90");
  if (goes_on_with_arc(found, machine.format.dialect))
    return fail(Code::kUsage, block +
                                  " is an arc without a G2 or G3 of its own: enter at a block that states "
                                  "one, or G1");
  if (machine.format.retract == "none")
    return fail(
        Code::kUsage,
        "the profile states no retract line (program.retract: none), and this control does not report "
        "where its axes are: move the tool clear by hand, and start a program of what is left");
  return {};
}

/// For the operator. `lines`: of the way in.
std::string preview_of(const WayIn& way, const std::vector<std::string>& lines, const Found& found,
                       std::uint64_t from) {
  std::string text =
      "0. by hand: take the tool clear of the part along its axis, for this control does not report where it "
      "stands; the program begins with the retract along the machine's Z\n"
      "1. then these lines, to " +
      decimal(way.height(), 1) + " mm over the end of the block before, along the tool axis" +
      (way.short_of() > 0.0 ? " (" + decimal(way.short_of(), 1) +
                                  " mm less than over every cut of the program: the travel ends there)"
                            : ", over every cut of the program") +
      ", and down to it at plunge feed\n";
  for (const std::string& line : lines) text += "   " + line + "\n";
  return text + "then " + block_text(from) + ", line " + std::to_string(found.line) + ": " + found.entry +
         "\n";
}

}  // namespace

Result<Reentry> plan_control_entry(const std::string& program, const config::MachineProfile& machine,
                                   const ReentryOptions& options) {
  if (options.from < 2) return fail(Code::kUsage, "block 1 needs no re-entry: start the job instead");
  const auto line = find_control_line(program, options.from);
  if (!line) return tl::unexpected<Error>(line.error());
  if (line->line == 0)
    return fail(Code::kUsage, block_text(options.from) + ": the program has " + std::to_string(line->count));
  Result<NcProgram> text = text_of(program, machine);
  if (!text) return tl::unexpected<Error>(text.error());
  Found found{std::move(*text), ControlState(machine.format), {}, line->line, "", {}};
  const config::Dialect dialect = machine.format.dialect;
  if (const auto read = follow(program, found, dialect); !read) return tl::unexpected<Error>(read.error());
  if (const auto can = check_entry(program, found, machine, options.from); !can)
    return tl::unexpected<Error>(can.error());
  const Result<std::vector<Setup>> setups = setups_of(found, options.setup, program);
  if (!setups) return tl::unexpected<Error>(setups.error());
  WayIn way(found, machine, options, *setups);
  const auto lines = way.lines();
  if (!lines) return tl::unexpected<Error>(lines.error());
  ControlState after(machine.format);
  for (const std::string& one : *lines) after.take(one);
  std::vector<std::string> all = *lines;
  for (const std::string& mode : found.state.lines_behind(after)) all.push_back(mode);
  Reentry entry{"", preview_of(way, all, found, options.from), found.line, "", "", true};
  for (const std::string& one : *lines) entry.held += one + "\n";
  const auto put = [&](const std::string& one) { entry.head += one + "\n"; };
  for (const std::string& one : found.header)
    if (ControlState known(machine.format); known.take(one), known.of_tool.empty()) put(one);
  for (const std::string& comment : found.state.of_tool) put("(" + comment + ")");
  put("(TILTFEED re-entry before " + block_text(options.from) + ", line " + std::to_string(found.line) + ")");
  for (const std::string& one : all) put(one);
  put(found.entry);
  return entry;
}

}  // namespace tiltfeed::daemon
