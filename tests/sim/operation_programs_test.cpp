// One program for several operations of a job, in every dialect: what stands between them, and that a damaged
// line there is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "sim/control/control_reader.h"
#include "sim/control/program_frame.h"
#include "sim/gcode/lines.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed::sim {
namespace {

using TextLines = std::vector<std::string>;

class OperationPrograms : public testing::TestWithParam<DialectCase> {
 protected:
  static JointPath path(double x) {
    JointPath path;
    path.moves = {{{x, -12.5, 100, 0, 0}, 0.0, MoveKind::kRapid, 0},
                  {{x + 1, -12.5, 10, 0, 0}, 4.0, MoveKind::kPlunge, 1},
                  {{x + 10, -12.5, 10, 0, 20.0}, 0.36, MoveKind::kCut, 2},
                  {{x + 10, -12.5, 100, 0, 20.0}, 0.5, MoveKind::kRapid, 3}};
    return path;
  }
  /// Tool 3 roughs, tool 4 finishes twice.
  OperationPrograms() {
    const JointPath paths[] = {path(0), path(20), path(-15)};
    Posting posting = posting_of(GetParam(), {&paths[0], &paths[1], &paths[2]});
    const char* const names[] = {"rough", "finish", "finish again"};
    for (std::size_t i = 0; i < 3; ++i) {
      Operation& op = posting.operations[i];
      op.name = {names[i], i + 1, 3};
      op.events = {{0, EventKind::kSpindle, 8000, ""}};
      if (i == 2) {
        const Operation& before = posting.operations[1];
        op.tool_number = before.tool_number, op.tool = before.tool, op.setup = before.setup;
        op.keeps_tool = true;
      }
      Job job;
      job.operation = op.name;
      job.machine = posting.machine;
      job.setup = op.setup;
      job.program.tool = op.tool_number;
      job.spindle_rpm = 8000;
      jobs_.push_back(job);
    }
    std::istringstream in(text_of(posting));
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
  }
  std::string fault(const TextLines& lines) const { return fault(lines, jobs_); }
  static std::string fault(const TextLines& lines, std::span<const Job> jobs) {
    std::string all;
    for (const std::string& line : lines) all += line + "\n";
    std::istringstream in(all);
    const auto sound = check_frame(in, "p.nc", jobs);
    return sound ? "" : sound.error().message;
  }
  /// Where the operation is marked, and where the next one is.
  std::pair<std::size_t, std::size_t> span(std::size_t operation) const {
    std::vector<std::size_t> marks;
    for (std::size_t i = 0; i < lines_.size(); ++i)
      if (lines_[i].find("TILTFEED operation ") != std::string::npos) marks.push_back(i);
    EXPECT_EQ(marks.size(), 3u);
    marks.push_back(lines_.size());
    return {marks[operation], marks[operation + 1]};
  }
  /// Lines of an operation with this word, outside of comments.
  std::vector<std::size_t> with(std::size_t operation, const std::string& word) const {
    std::vector<std::size_t> found;
    for (auto [i, end] = span(operation); i < end; ++i)
      if (lines_[i].find(word) != std::string::npos && lines_[i].find("TILTFEED") == std::string::npos)
        found.push_back(i);
    return found;
  }

  /// A word of the retract along the machine's Z.
  static std::string retract() {
    switch (GetParam().dialect) {
      case Dialect::kFanuc:
        return "G28";
      case Dialect::kSiemens:
        return "SUPA";
      case Dialect::kHeidenhain:
      case Dialect::kHeidenhainIso:
        return "M91";
      default:
        return "G53";
    }
  }

  std::vector<Job> jobs_;
  TextLines lines_;
};

INSTANTIATE_TEST_SUITE_P(Control, OperationPrograms, testing::ValuesIn(dialect_cases()), case_name);

/// A Heidenhain control states the tool with the spindle's speed, too.
TEST_P(OperationPrograms, AToolIsChangedOnlyWhereTheNextHasAnother) {
  EXPECT_EQ(fault(lines_), "");
  const bool dialogue = GetParam().dialect == Dialect::kHeidenhain;
  const std::string second = dialogue ? "TOOL CALL 4" : "T4", first = dialogue ? "TOOL CALL 3" : "T3";
  EXPECT_EQ(with(0, first).size(), 1u);
  EXPECT_EQ(with(1, second).size(), 1u);
  EXPECT_TRUE(with(2, second).empty());
}

/// The control's reader puts each operation's tip where its own tool is.
TEST_P(OperationPrograms, EveryOperationIsReadWithItsOwnTool) {
  std::string all;
  for (const std::string& line : lines_) all += line + "\n";
  std::istringstream in(all);
  tiltfeed::sim::Lines lines(in);
  FrameCheck frame("p.nc", jobs_);
  ControlReader reader(jobs_[0].machine, jobs_[0].setup);
  std::vector<ControlBlock> blocks;
  std::vector<std::size_t> cuts(3);
  std::size_t operation = 0;
  while (const auto line = lines.next()) {
    ASSERT_TRUE(frame.take(*line));
    if (frame.operation() != operation) reader.use(jobs_[operation = frame.operation()].setup);
    blocks.clear();
    if (reader.ended()) break;
    ASSERT_TRUE(reader.read_line(*line, blocks)) << *line;
    for (const ControlBlock& one : blocks)
      if (one.block.op == Op::kFeed) ++cuts[operation];
  }
  EXPECT_EQ(cuts, (std::vector<std::size_t>{2, 2, 2}));
}

TEST_P(OperationPrograms, WhatIsLostBetweenThemIsRefused) {
  // The marks: one is lost, two change places, a name is another's, one comes twice.
  for (std::size_t i = 0; i < 3; ++i) {
    TextLines lost = lines_;
    lost.erase(lost.begin() + static_cast<std::ptrdiff_t>(span(i).first));
    EXPECT_NE(fault(lost), "") << i;
    TextLines twice = lines_;
    twice.insert(twice.begin() + static_cast<std::ptrdiff_t>(span(i).first), lines_[span(i).first]);
    EXPECT_NE(fault(twice), "") << i;
    TextLines renamed = lines_;
    std::string& mark = renamed[span(i).first];
    mark.replace(mark.find("operation ") + 15, 1, "x");
    EXPECT_NE(fault(renamed), "") << i;
    TextLines longer = lines_;
    std::string& more = longer[span(i).first];
    more.insert(more.find(i == 0 ? "rough" : "finish"), "x");
    EXPECT_NE(fault(longer), "") << i;
    TextLines behind = lines_;
    std::string& end = behind[span(i).first];
    const std::string name = jobs_[i].operation.name;
    end.insert(end.find(name) + name.size(), "y");
    EXPECT_NE(fault(behind), "") << i;
  }
  // The retract before the next one, which has the same tool.
  const auto places = with(1, retract());
  ASSERT_FALSE(places.empty());
  TextLines low = lines_;
  low.erase(low.begin() + static_cast<std::ptrdiff_t>(places.back()));
  EXPECT_NE(fault(low), "") << lines_[places.back()];
  TextLines swapped = lines_;
  std::swap(swapped[span(1).first], swapped[span(2).first]);
  EXPECT_NE(fault(swapped), "");
  // The tools: the change is lost, or is to another.
  const bool dialogue = GetParam().dialect == Dialect::kHeidenhain;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string word = (dialogue ? "TOOL CALL " : "T") + std::to_string(3 + i);
    ASSERT_EQ(with(i, word).size(), 1u);
    const std::size_t at = with(i, word)[0];
    TextLines lost = lines_;
    lost.erase(lost.begin() + static_cast<std::ptrdiff_t>(at));
    EXPECT_NE(fault(lost), "") << lines_[at];
    TextLines other = lines_;
    other[at].replace(other[at].find(word), word.size(),
                      (dialogue ? "TOOL CALL " : "T") + std::to_string(4 - i));
    EXPECT_NE(fault(other), "") << other[at];
  }
  // A change that no operation asks for.
  TextLines more = lines_;
  more.insert(more.begin() + static_cast<std::ptrdiff_t>(span(2).first + 1),
              dialogue ? "TOOL CALL 3 Z" : "T3");
  EXPECT_NE(fault(more), "");
  // The spindle of each.
  for (std::size_t i = 0; i < 3; ++i) {
    const auto turns = with(i, GetParam().dialect == Dialect::kHeidenhain ? "M3" : "S8000");
    ASSERT_FALSE(turns.empty());
    TextLines stands = lines_;
    stands.erase(stands.begin() + static_cast<std::ptrdiff_t>(turns[0]));
    EXPECT_NE(fault(stands), "") << lines_[turns[0]];
  }
}

TEST_P(OperationPrograms, ItIsTheProgramOfTheWholeJobAlone) {
  EXPECT_NE(fault(lines_, std::span(jobs_).first(2)), "") << "a third one comes";
  EXPECT_NE(fault(lines_, std::span(jobs_).subspan(1, 1)), "") << "the first one is another";
  Job plain = jobs_[0];
  plain.operation = {};
  EXPECT_NE(fault(lines_, std::span(&plain, 1)), "") << "the job has none";
  std::vector<Job> four = jobs_;
  four.push_back(jobs_[2]);
  EXPECT_NE(fault(lines_, four), "") << "the last one does not come";
}

}  // namespace
}  // namespace tiltfeed::sim
