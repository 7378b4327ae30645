#include "daemon/program/operation_span.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <optional>
#include <string_view>

#include "daemon/program/block_cursor.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/tool_change.h"

namespace tiltfeed::daemon {

namespace {

constexpr std::string_view kMark = "TILTFEED operation ", kOf = " of ";
// The header names the first operation: programs without are not read to their end.
constexpr std::uint64_t kHeaderLines = 50;

/// Takes a number off the front.
std::optional<std::uint64_t> take_number(std::string_view& text) {
  std::uint64_t number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (code != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

/// What the comment of a line says; `first` is not known yet.
std::optional<OperationSpan> mark_in(std::string_view comment) {
  if (!comment.starts_with(kMark)) return std::nullopt;
  comment.remove_prefix(kMark.size());
  const auto number = take_number(comment);
  if (!number || !comment.starts_with(kOf)) return std::nullopt;
  comment.remove_prefix(kOf.size());
  const auto count = take_number(comment);
  if (!count || !comment.starts_with(' ')) return std::nullopt;
  comment.remove_prefix(1);
  const std::size_t last = comment.find_last_not_of(" *\r");
  return OperationSpan{std::string(comment.substr(0, last + 1)), *number, *count};
}

struct Mark {
  OperationSpan operation;
  std::uint64_t line = 0;
};

Result<std::vector<Mark>> read_marks(const std::string& path) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected(program.error());
  std::vector<Mark> marks;
  std::string_view raw;
  while (!marks.empty() || program->number() < kHeaderLines) {
    const Result<bool> more = program->read_raw(raw);
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    if (auto mark = mark_in(comment_of(raw))) marks.push_back({std::move(*mark), program->number()});
  }
  return marks;
}

/// Block by block: its number and its line of the file. False: no more are wanted.
using Pass = std::function<bool(std::uint64_t block, std::uint64_t line)>;

Result<void> walk_blocks(const std::string& path, LinkKind kind, const MachineModel& machine,
                         const Pass& pass) {
  Result<BlockCursor> program = BlockCursor::open(path, kind, machine);
  if (!program) return tl::unexpected(program.error());
  for (WalkedBlock block;;) {
    const Result<bool> more = program->next(block);
    if (!more) return tl::unexpected(more.error());
    if (!*more || !pass(block.block, block.line)) return {};
  }
}

/// Of a link that counts lines: in the words of any control, none of which has to be understood.
Result<void> walk_lines(const std::string& path, const Pass& pass) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected(program.error());
  std::uint64_t count = 0;
  for (Line line;;) {
    const Result<bool> more = program->next(line);
    if (!more) return tl::unexpected(more.error());
    if (!*more || !pass(++count, line.number)) return {};
  }
}

}  // namespace

Result<std::vector<OperationSpan>> read_operations(const std::string& path, LinkKind kind,
                                                   const MachineModel& machine) {
  const Result<std::vector<Mark>> marks = read_marks(path);
  if (!marks) return tl::unexpected(marks.error());
  std::vector<OperationSpan> operations;
  if (marks->empty()) return operations;
  auto mark = marks->begin();
  const auto pass = [&](std::uint64_t block, std::uint64_t line) {
    for (; mark != marks->end() && mark->line < line; ++mark) {
      operations.push_back(mark->operation);
      operations.back().first = operations.size() == 1 ? 1 : block;
    }
    return mark != marks->end();
  };
  const auto walked =
      counts_numeric_blocks(kind) ? walk_blocks(path, kind, machine, pass) : walk_lines(path, pass);
  if (!walked) return tl::unexpected(walked.error());
  return operations;
}

const OperationSpan* operation_at(const std::vector<OperationSpan>& operations, std::uint64_t block) {
  const auto after =
      std::upper_bound(operations.begin(), operations.end(), block,
                       [](std::uint64_t at, const OperationSpan& one) { return at < one.first; });
  return after == operations.begin() ? nullptr : &*std::prev(after);
}

}  // namespace tiltfeed::daemon
