#pragma once
// Tool changes of a program that the operator makes: M6, or a T line with M0 on the next one, as the grbl
// dialect has it. Another M0, and M1, are pauses.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/program/line.h"
#include "daemon/program/link_kind.h"
#include "daemon/program/numeric_block.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Takes the lines of a program in their order.
class ToolChangeReader {
 public:
  /// The line is a tool change. Errors: kInput: M6 with words beside N and T, which would be kept back, too.
  Result<bool> take(const Line& line);
  /// The newest T word; nothing before the first.
  std::optional<int> tool() const { return tool_; }

 private:
  std::optional<int> tool_;
  bool chosen_ = false;  // the line before chose a tool, and did nothing else
};

struct ToolChange {
  std::uint64_t block = 0;  ///< its own, counted from 1 as the link counts
  std::uint64_t line = 0;   ///< of the file
  std::optional<int> tool;  ///< T
  std::string name;         ///< what the program's comments call the tool; may be empty
  std::optional<double> length =
      {};  ///< mm, that the program's TILTFEED comment says is in the words after it
};
/// The comment of a line as it stands in the file, in brackets or after a semicolon, without
/// blanks before it; empty: it has none.
std::string_view comment_of(std::string_view raw);
/// It says which tool length is in the words of the lines after it.
bool states_length(std::string_view comment);
/// "T3 (ball 6 mm)", "T3", "tool not named".
std::string tool_text(const ToolChange& change);

/// "length 100.02 mm, 0.02 mm longer than the program's 100, which is allowed". Errors: kUsage: no such tool;
/// kLimit: it is further than `allowed` off the length that the program says is in its words.
Result<std::string> judge_length(const ToolChange& change, double length, double allowed);

/// All of a program; none where another link than the Grbl family, RepRap and the ring has it. Errors: kIo;
/// kInput with path:line: as `take`; a line before a change, from the first motion on, that is not understood
/// (nobody could say where to go back to, and with which modes).
Result<std::vector<ToolChange>> read_tool_changes(const std::string& path, LinkKind kind,
                                                  const NumericAxes& axes);

/// A line of a text link as far as it leads somewhere: feeds and arcs as rapids to their ends, without the
/// words that lead nowhere.
std::string straightened(const std::string& text);

/// The part of a program that is sent in one go: from after a tool change, or the start, to before the next.
struct ProgramSpan {
  std::uint64_t after = 0;              ///< blocks before it, tool changes included
  std::uint64_t last = 0;               ///< its last block, or `after` where it has none
  std::optional<ToolChange> next = {};  ///< what comes then; nothing: the program's end
};
/// The span of a program of `total` blocks in which a run stands that has executed so many.
ProgramSpan span_at(const std::vector<ToolChange>& changes, std::uint64_t total, std::uint64_t executed);

}  // namespace tiltfeed::daemon
