// Where a program has tool changes, what is between them, and the ways off the part and back.

#include "daemon/program/tool_change.h"

#include <gtest/gtest.h>

#include "daemon/journal/run_recorder.h"
#include "daemon/journal/tool_return.h"
#include "tests/peers/operator_shop.h"
#include "tests/texts/folder.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

bool has(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

const NumericAxes kAxes = numeric_axes(shop_machine());

struct Program {
  explicit Program(const std::string& text) : path(folder.write("p.nc", text)) {}
  Folder folder{"tool_change"};
  std::string path;
  Result<std::vector<ToolChange>> changes(LinkKind kind = LinkKind::kGrbl) const {
    return read_tool_changes(path, kind, kAxes);
  }
};

/// Block numbers of the changes, as text.
std::string found(const std::string& text, LinkKind kind = LinkKind::kGrbl) {
  const auto changes = Program(text).changes(kind);
  if (!changes) return changes.error().message;
  std::string numbers;
  for (const ToolChange& one : *changes) numbers += std::to_string(one.block) + ":" + tool_text(one) + " ";
  return numbers;
}

TEST(ToolChange, D21M6IsOneAndAPauseIsNot) {
  EXPECT_EQ(found("G21\nM0\nM1\nG0X0\nM60\nM06 T2\nN7 T3M6\nM6\n"), "6:T2 7:T3 8:T3 ");
  EXPECT_EQ(found("M6\nM2\nM6\n"), "1:tool not named ") << "nothing after the program's end";
  // The grbl dialect: T, then M0. Anything between them makes it a pause.
  EXPECT_EQ(found("T4\nM0\nT5\nM1\nT6\nG0X0\nM0\nT7 S1\nM0\nM0\nN1T8\nN2M0\n"), "2:T4 12:T8 ");
  EXPECT_EQ(found("(T1 M6)\nG0 X0 ; M6\n"), "") << "comments";
  for (const LinkKind kind : {LinkKind::kDrip, LinkKind::kDriveTcp}) EXPECT_EQ(found("T1M6\n", kind), "");
  // A ring counts blocks: T has none.
  EXPECT_EQ(found("T4\nM0\nG0 X0 Y0 Z0 A0 C0\nT5 M6\n", LinkKind::kModbusTcp), "1:T4 3:T5 ");
}

TEST(ToolChange, D21NamesAndLengthsAreOfTheComments) {
  const Program program(
      "(TILTFEED tool length 100.25 mm is in the words, use G49)\nT3 M6 (ball; 6 mm)\nG0X0\n"
      "(TILTFEED tool length 80 mm is planned, TCP takes the control's)\nT4 ; drill\nM0\n"
      "(TILTFEED tool length 7 mm is in the words)\nM6 T5\n");
  const auto changes = *program.changes();
  ASSERT_EQ(changes.size(), 3u);
  EXPECT_EQ(changes[0].name, "ball; 6 mm");
  EXPECT_EQ(changes[0].length, 100.25);
  EXPECT_EQ(changes[1].name, "drill");
  EXPECT_EQ(changes[2].length, 7.0);
  EXPECT_EQ(changes[2].line, 8u);
}

TEST(ToolChange, D21WhatWouldBeKeptBackWithItIsRefusedBeforeAnythingIsSent) {
  for (const char* line : {"T1 M6 G43 H1", "M6 S100 M3", "G0 X1 M6", "M6 M0"})
    EXPECT_TRUE(has(found(std::string("G21\n") + line + "\n"), "line of its own")) << line;
  // Nobody could say where to go back to.
  for (const char* line : {"G91", "G20", "G43 H1", "G55", "G28"})
    EXPECT_TRUE(has(found(std::string("G0 X0\n") + line + "\nM6\n"), "how to go back")) << line;
  // Relative moves, as a re-entry's retract is one: known again once each axis that they moved has got a
  // place.
  const std::string retract = "G0 X0 Y0 Z0\nG91\nG1 Y1 Z5 F100\nG90\n";
  EXPECT_EQ(found(retract + "G0 Z9\nX1 Y2\nT1 M6\n"), "7:T1 ");
  for (const char* line : {"", "G0 Z9\n", "Y2\n", "X1 Y2 Z3 G91\n", "G0 Y2 Z3\nG91\n", "G20\n"})
    EXPECT_TRUE(has(found(retract + line + "T1 M6\n"), "how to go back")) << line;
  EXPECT_EQ(found("G0 X0 Y0\nG1 X1 F100\nG2 X5 Y0 I2 J0\nG4 P1\nM62 P1\nT1 M6\nG91\nG20\n"), "6:T1 ")
      << "arcs lead to their ends, and what comes after the last change is not looked at";
}

TEST(ToolChange, D21SpansLeaveOutNothingButTheChanges) {
  const std::vector<ToolChange> changes{{3, 3, 1, "", {}}, {4, 4, 2, "", {}}, {9, 9, 3, "", {}}};
  std::uint64_t sent = 0, block = 0;
  for (std::uint64_t executed = 0;;) {
    const ProgramSpan span = span_at(changes, 12, executed);
    EXPECT_EQ(span.after, block);
    for (std::uint64_t one = span.after + 1; one <= span.last; ++one) ++sent;
    block = span.last;
    if (!span.next) break;
    EXPECT_EQ(span.next->block, ++block);
    executed = span.next->block;
  }
  EXPECT_EQ(sent, 9u);
  EXPECT_EQ(block, 12u);
  // In the middle of a span, too.
  for (const std::uint64_t executed : {4u, 6u, 8u}) EXPECT_EQ(span_at(changes, 12, executed).after, 4u);
}

TEST(ToolChange, D21ALengthIsHeldAgainstTheProgram) {
  const ToolChange change{1, 1, 3, "", 100.0}, silent{1, 1, 3, "", {}};
  EXPECT_TRUE(has(*judge_length(change, 100.0, 0.1), "as in the program"));
  EXPECT_TRUE(has(*judge_length(change, 100.1, 0.1 + 1e-9), "0.1 mm longer"));
  EXPECT_TRUE(has(judge_length(change, 100.2, 0.1).error().message, "0.2 mm longer"));
  EXPECT_TRUE(has(judge_length(change, 99.8, 0.1).error().message, "0.2 mm shorter"));
  EXPECT_TRUE(judge_length(silent, 12.0, 0.1));
  for (const double bad : {0.0, -1.0, 1e4, std::nan("")}) EXPECT_FALSE(judge_length(silent, bad, 0.1));
}

MachineProfile shop() {
  MachineProfile profile;
  profile.model = shop_machine();
  return profile;
}

TEST(ToolChange, D21TheWaysOffAndBackInTheirOrder) {
  const Program program("G21 G90\nG0 X0 Y0 Z50 A90 C30\nM3 S900\nM8\nG93\nG1 X10 F60\nT3 M6\nX11 F60\n");
  ReturnOptions options;
  options.change = 7;
  const auto park = plan_park(program.path, LinkKind::kGrbl, shop(), options),
             back = plan_return(program.path, LinkKind::kGrbl, shop(), options);
  ASSERT_TRUE(park && back);
  // The tool lies along Y at A90: off along it means along Y, not up.
  const Pose stands = forward(shop().model, {}, {10, 0, 50, 90, 30});
  const Joints off = solve_linear(shop().model, {}, stands.tip + stands.axis * 50.0, 90, 30);
  EXPECT_NEAR(off.z, 50.0, 1e-9);
  EXPECT_NEAR(std::abs(off.y), 50.0, 1e-9);
  const std::string y = off.y > 0 ? "50" : "-50";
  EXPECT_EQ(park->program, "G21\nG90\nG94\nG1 X10 Y" + y + " Z50 A90 C30 F200\nM5\nM9\nG53 G0 Z0\n");
  // Down to 50 over Z50, the highest place of the program so far.
  EXPECT_EQ(back->program,
            "G21\nG90\nG94\nG53 G0 Z0\nG0 A90 C30\nG0 X10 Y" + y +
                "\nM3 S900\nM8\nG4 P3\nG0 Z100\nG1 Z50 F200\nG1 X10 Y0 Z50 F200\nG1 F200\nG93\n");
}

TEST(ToolChange, D21WhatTheProgramHasNotSaidStaysWhereItIs) {
  ReturnOptions options;
  options.change = 4;
  const Program retracted("G0 X1 Y2 Z3 A4 C5\nM5\nG53 G0 Z0\nT3 M6\n");
  EXPECT_EQ(plan_return(retracted.path, LinkKind::kGrbl, shop(), options)->program,
            "G21\nG90\nG94\nG53 G0 Z0\nG0 A4 C5\nG0 X1 Y2\nG0\n");
  EXPECT_EQ(plan_park(retracted.path, LinkKind::kGrbl, shop(), options)->program,
            "G21\nG90\nG94\nM5\nM9\nG53 G0 Z0\n");
  options.change = 1;
  const Program first("T3 M6\nG0 X0\n");
  EXPECT_EQ(plan_return(first.path, LinkKind::kGrbl, shop(), options)->program,
            "G21\nG90\nG94\nG53 G0 Z0\nG0\n");
  MachineProfile none = shop();
  none.format.retract = "none";
  EXPECT_TRUE(has(plan_park(first.path, LinkKind::kGrbl, none, options).error().message, "no retract line"));
}

/// A jog or a probing during the change may have led any axis away from a place of the machine's own.
/// Of a posted program, as of a job's: it has gone to the retract before every change, so that the parking
/// moves nothing that its proof has not seen.
TEST(ToolChange, D21APostedProgramStandsAtTheRetractAtEveryChange) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc", "mill-4x-table-a"})
    for (const char* retract : {"default", "G53 G0 Z-5"}) {
      MachineProfile profile = machine(Dialect::kGrbl, false, name);
      profile.format.retract = retract;
      AptProgram stated = foreign();
      for (AptOperation& operation : stated.operations)
        for (Move& move : operation.path.moves) move.pose.axis = {0, 0, 1};
      const auto text = program_text(stated, profile, {});
      ASSERT_TRUE(text) << name << ": " << text.error().message;
      const Folder folder("tool_change_posted");
      const std::string path = folder.write("p.nc", *text);
      const auto changes = read_tool_changes(path, LinkKind::kGrbl, numeric_axes(profile.model));
      ASSERT_TRUE(changes) << changes.error().message;
      ASSERT_EQ(changes->size(), 2u) << *text;
      for (const ToolChange& change : *changes) {
        ReturnOptions at;
        at.change = change.block;
        const auto park = plan_park(path, LinkKind::kGrbl, profile, at);
        ASSERT_TRUE(park) << park.error().message;
        const std::string up = profile.format.retract == "default" ? "G53 G0 Z0" : retract;
        EXPECT_EQ(park->program, "G21\nG90\nG94\nM5\nM9\n" + up + "\n") << name;
      }
    }
}

TEST(ToolChange, D21TheWayBackLeadsToPlacesOfTheMachinesOwnToo) {
  ReturnOptions options;
  options.change = 4;
  const Program aside("G0 X1 Y2 Z3 A4 C5\nG53 G0 Z-2\nG53 G0 X-300 Y-10\nT3 M6\n");
  EXPECT_EQ(plan_return(aside.path, LinkKind::kGrbl, shop(), options)->program,
            "G21\nG90\nG94\nG53 G0 Z0\nG0 A4 C5\nG53 G0 X-300 Y-10\nG53 G0 Z-2\nG0\n");
  const Program beside("G0 X1 Y2 Z3 A4 C5\nG53 G0 X-300\nM8\nT3 M6\n");
  EXPECT_EQ(plan_return(beside.path, LinkKind::kGrbl, shop(), options)->program,
            "G21\nG90\nG94\nG53 G0 Z0\nG0 A4 C5\nG0 Y2\nG53 G0 X-300\nM8\nG1 Z3 F200\nG0\n");
}

/// G93 forgets the F of G94, and the G1 before it stays in force: the next line would be a rapid else.
TEST(ToolChange, D21TheMotionModeSurvivesAChangeOfTheFeedMode) {
  const Program program("G0 X0 Y0 Z50 A0 C0\nG1 Z5 F100\nG93\nT3 M6\nX11 F60\n");
  ReturnOptions options;
  options.change = 4;
  const std::string back = plan_return(program.path, LinkKind::kGrbl, shop(), options)->program;
  EXPECT_TRUE(back.ends_with("G1 X0 Y0 Z5 F200\nG1 F200\nG93\n")) << back;
}

/// The journal alone says that nothing of what comes after the change has left.
TEST(ToolChange, D21TheJournalStandsBeforeTheChangeUntilABlockAfterItLeaves) {
  std::string file;
  JournalDisk disk;
  disk.read = [&]() -> Result<std::string> { return file; };
  disk.write = [&](std::uint64_t at, std::string_view bytes) {
    file.resize(std::max(file.size(), static_cast<std::size_t>(at) + bytes.size()));
    file.replace(static_cast<std::size_t>(at), bytes.size(), bytes);
    return static_cast<std::ptrdiff_t>(bytes.size());
  };
  disk.sync = [] { return 0; };
  disk.replace = [&](std::string_view content) { return file = content, 0; };
  disk.name = "memory";
  auto journal = *Journal::open(disk);
  RunSubject subject{1, 100, {}, LinkKind::kGrbl, 7, {}, 0, 9};
  const auto way = [&] { return decide_resume(read_journal(file), subject); };
  SendState state;
  state.phase = Phase::kRun;
  auto first = *RunRecorder::begin(journal, subject);
  EXPECT_EQ(way().way, ResumeWay::kFresh);
  ASSERT_TRUE(first.reserve(1, Time(0)));
  EXPECT_EQ(way().may_have, 9u) << "no further than to the change";
  EXPECT_FALSE(first.reserve(10, Time(0))) << "the change itself never leaves";
  state.executed = state.acknowledged = 9;
  state.phase = Phase::kDrain;
  ASSERT_TRUE(first.progress(state, Time(1)));
  EXPECT_EQ(way().way, ResumeWay::kToolChange) << "on record before the controller is let go of";
  EXPECT_EQ(way().executed, 9u);
  subject.after = 10;
  subject.last = 100;
  auto second = *RunRecorder::begin(journal, subject);
  EXPECT_EQ(way().way, ResumeWay::kToolChange) << "the way back is no block of the program";
  EXPECT_EQ(way().executed, 9u);
  ASSERT_TRUE(second.reserve(11, Time(2)));
  EXPECT_EQ(way().way, ResumeWay::kUncertain);
  EXPECT_GE(way().may_have, 11u);
  EXPECT_EQ(way().executed, 9u);
  // A record that is damaged may have been such a reservation.
  file.clear();
  auto again = *RunRecorder::begin(journal, subject);
  static_cast<void>(again);
  file.replace(kRecordBytes, 4, "????");
  EXPECT_EQ(way().way, ResumeWay::kUncertain);
}

}  // namespace
}  // namespace tiltfeed
