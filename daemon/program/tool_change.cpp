#include "daemon/program/tool_change.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "daemon/program/block_cursor.h"
#include "daemon/program/line_reader.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

constexpr double kMostTool = 1e6, kMostLength = 1e4;
constexpr std::string_view kLengthMark = "TILTFEED tool length ", kInWords = "in the words";
constexpr std::size_t kMostName = 40;

std::string printable(std::string_view text) {
  std::string kept;
  for (const char c : text)
    if (c >= ' ' && c <= '~' && kept.size() < kMostName) kept += c;
  const std::size_t first = kept.find_first_not_of(' '), last = kept.find_last_not_of(' ');
  return first == kept.npos ? "" : kept.substr(first, last - first + 1);
}

/// What the comments say of the tools: a name beside the change or its T, a length in the lines before it.
/// Errors: kIo.
Result<void> add_comments(LineReader& program, std::vector<ToolChange>& changes) {
  if (const Result<void> back = program.rewind(); !back) return back;
  std::string before;
  std::string_view raw;
  std::optional<double> length;
  for (auto next = changes.begin(); next != changes.end(); before = raw) {
    const Result<bool> more = program.read_raw(raw);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    const std::string_view comment = comment_of(raw);
    if (states_length(comment)) {
      double value = 0.0;
      const std::string_view figure = comment.substr(kLengthMark.size());
      if (std::from_chars(figure.data(), figure.data() + figure.size(), value).ec == std::errc())
        length = value;
    }
    if (program.number() != next->line) continue;
    const bool chosen_before = before.find_first_of("Tt") != before.npos && before[0] != '(';
    next->name = printable(!comment.empty() ? comment : chosen_before ? comment_of(before) : "");
    next->length = length;
    ++next;
  }
  return {};
}

}  // namespace

std::string_view comment_of(std::string_view raw) {
  const std::size_t open = raw.find_first_of("(;");
  if (open == raw.npos) return {};
  const std::size_t close = raw[open] == ';' ? raw.size() : raw.find(')', open);
  if (close == raw.npos) return {};
  const std::string_view comment = raw.substr(open + 1, close - open - 1);
  return comment.substr(std::min(comment.find_first_not_of(" \t"), comment.size()));
}

bool states_length(std::string_view comment) {
  return comment.starts_with(kLengthMark) && comment.find(kInWords) != comment.npos;
}

Result<bool> ToolChangeReader::take(const Line& line) {
  const bool chosen = chosen_;
  chosen_ = false;
  if (line.text.find_first_of("MT") == line.text.npos) return false;
  bool changes = false, pauses = false, others = false;
  std::optional<int> tool;
  std::string_view rest = line.text;
  while (!rest.empty()) {
    const std::optional<GcodeWord> word = take_word(rest);
    if (!word) return false;  // another language than words
    if (word->letter == 'T' && word->value >= 0.0 && word->value < kMostTool)
      tool = static_cast<int>(word->value);
    else if (word->letter == 'M' && word->value == 6.0)
      changes = true;
    else if (word->letter == 'M' && word->value == 0.0)
      pauses = true;
    else if (word->letter != 'N')
      others = true;
  }
  if (tool) tool_ = tool;
  if (changes && (others || pauses))
    return fail(Code::kInput,
                "a tool change that the operator makes stands in a line of its own, with T at most: move the "
                "other words to the next line, or leave the change to the control (wire.tool_changes: "
                "control)");
  chosen_ = tool && !changes && !pauses && !others;
  return changes || (chosen && pauses && !others && !tool);
}

std::string tool_text(const ToolChange& change) {
  if (!change.tool) return "tool not named";
  return "T" + std::to_string(*change.tool) + (change.name.empty() ? "" : " (" + change.name + ")");
}

Result<std::string> judge_length(const ToolChange& change, double length, double allowed) {
  if (!(length > 0.0 && length < kMostLength))
    return fail(Code::kUsage, "a tool's length is above 0 and below 10000 mm");
  const std::string text = "length " + decimal(length, 4) + " mm";
  if (!change.length) return text + ", the program says nothing of one";
  const double off = length - *change.length;
  const std::string wanted = decimal(*change.length, 4),
                    by = decimal(std::abs(off), 4) + " mm " + (off < 0.0 ? "shorter" : "longer");
  if (std::abs(off) > allowed)
    return fail(Code::kLimit,
                "the tool is " + decimal(length, 4) + " mm long, " + by + " than the " + wanted +
                    " mm in the program's words, and " + decimal(allowed, 4) +
                    " is allowed (wire.tool_length_tolerance_mm): mount another, or end the run "
                    "and post the program with this length");
  if (off == 0.0) return text + ", as in the program";
  return text + ", " + by + " than the program's " + wanted + ", which is allowed";
}

std::string straightened(const std::string& text) {
  std::string straight;
  bool switched = false;  // by a code whose P this is
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view from = rest;
    const std::optional<GcodeWord> word = take_word(rest);
    if (!word) return text;
    if (word->letter == 'G' && word->value == 4.0) return "";  // seconds or milliseconds, it leads nowhere
    const bool leads = word->letter == 'G' && word->value >= 1.0 && word->value <= 3.0;
    const bool switches = word->letter == 'M' && word->value > 9.0 && word->value != 30.0;
    switched = switched || switches;
    if (switches || (switched && word->letter == 'P') ||
        std::string_view("IJKREQ").find(word->letter) != std::string_view::npos)
      continue;
    straight += leads ? "G0" : from.substr(0, from.size() - rest.size());
  }
  return straight;
}

Result<std::vector<ToolChange>> read_tool_changes(const std::string& path, LinkKind kind,
                                                  const NumericAxes& axes) {
  std::vector<ToolChange> changes;
  if (kind != LinkKind::kGrbl && kind != LinkKind::kRepRap && !is_ring(kind)) return changes;
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  ToolChangeReader reader;
  const bool by_line = !counts_numeric_blocks(kind);
  BlockReader numbers(axes, by_line);
  Line line;
  std::vector<NumericBlock> blocks;
  std::optional<Error> not_understood;
  std::uint64_t count = 0;
  bool moved = false;
  for (;;) {
    const Result<bool> more = program->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    const auto at_line = [&](std::uint64_t number, const std::string& what) {
      return fail(Code::kInput, path + ":" + std::to_string(number) + ": " + what);
    };
    const Result<bool> change = reader.take(line);
    if (!change) return at_line(line.number, "'" + line.text + "': " + change.error().message);
    blocks.clear();
    if (by_line) line.text = straightened(line.text);
    if (!not_understood)
      if (const Result<void> read = numbers.read(line, blocks); !read)
        not_understood = at_line(line.number, "'" + line.text + "': " + read.error().message).value();
    moved = moved || not_understood || std::any_of(blocks.begin(), blocks.end(), [](const auto& one) {
              return one.op == BlockOp::kRapid || one.op == BlockOp::kFeed;
            });
    count += by_line ? 1 : blocks.size();
    if (!*change) continue;
    if (!not_understood && (numbers.relative() || numbers.lost()))
      not_understood = at_line(line.number, "'" + line.text +
                                                "': relative moves (G91) lead to it, and not every axis "
                                                "that they moved has got a place since")
                           .value();
    if (moved && not_understood)
      return fail(not_understood->code,
                  not_understood->message +
                      "; so nobody can say how to go back after the tool change of line " +
                      std::to_string(line.number) +
                      "; where the control changes tools itself say wire.tool_changes: control");
    changes.push_back({count, line.number, reader.tool(), "", {}});
  }
  if (const Result<void> named = add_comments(*program, changes); !named)
    return tl::unexpected<Error>(named.error());
  return changes;
}

ProgramSpan span_at(const std::vector<ToolChange>& changes, std::uint64_t total, std::uint64_t executed) {
  ProgramSpan span{0, total, {}};
  for (const ToolChange& change : changes) {
    if (change.block > executed) {
      span.last = change.block - 1;
      span.next = change;
      break;
    }
    span.after = change.block;
  }
  return span;
}

}  // namespace tiltfeed::daemon
