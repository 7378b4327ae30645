// Canonical commands of rs274 as blocks, and both readings of one program executed alike.

#include "sim/gcode/canon.h"

#include <gtest/gtest.h>

#include <sstream>

#include "sim/motion/dry_run.h"
#include "tests/peers/sim_machine.h"

namespace tiltfeed::sim {
using namespace config;
namespace {

// As rs274 of LinuxCNC 2.9 printed it for kProgram.
const std::string kCanon =
    "    1 N..... USE_LENGTH_UNITS(CANON_UNITS_MM)\n"
    "    2 N..... SET_G5X_OFFSET(1, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)\n"
    "    3 N..... SET_G92_OFFSET(0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)\n"
    "    4 N..... SET_XY_ROTATION(0.0000)\n"
    "    5 N..... SET_FEED_REFERENCE(CANON_XYZ)\n"
    "    6 N..... ON_RESET()\n"
    "   11 N..... COMMENT(\"interpreter: continuing to use same coordinate system\")\n"
    "   10 N..... USE_TOOL_LENGTH_OFFSET(0.0000 0.0000 0.0000, 0.0000 0.0000 0.0000, 0.0000 0.0000 0.0000)\n"
    "   12 N..... SET_SPINDLE_SPEED(0, 12000.0000)\n"
    "   13 N..... START_SPINDLE_CLOCKWISE(0)\n"
    "   15 N..... SET_MOTION_CONTROL_MODE(CANON_EXACT_STOP)\n"
    "   16 N..... STRAIGHT_TRAVERSE(1.0000, 2.0000, 30.0000, 10.0000, 0.0000, -20.0000)\n"
    "   17 N..... DWELL(0.2500)\n"
    "   18 N..... SET_MOTION_CONTROL_MODE(CANON_CONTINUOUS, 0.010000)\n"
    "   19 N..... SET_NAIVECAM_TOLERANCE(0.0100)\n"
    "   21 N..... SET_FEED_MODE(0, 0)\n"
    "   22 N..... SET_FEED_RATE(410.0000)\n"
    "   23 N..... STRAIGHT_FEED(1.0000, 2.0000, 10.0000, 12.0000, 0.0000, -25.0000)\n"
    "   32 N..... SET_FEED_RATE(0.0000)\n"
    "   33 N..... SET_FEED_RATE(100.0000)\n"
    "   34 N..... STRAIGHT_FEED(1.0000, 2.0000, 10.0000, 20.0000, 0.0000, -25.0000)\n"
    "   37 N..... STOP_SPINDLE_TURNING(0)\n"
    "   45 N..... SET_SPINDLE_MODE(0 0.0000)\n"
    "   46 N..... PALLET_SHUTTLE()\n"
    "   47 N..... PROGRAM_END()\n"
    "   48 N..... ON_RESET()\n";
const std::string kProgram =
    "G21 G90 G17 G40 G49 G54\nS12000 M3\nG61.1\nG0 X1 Y2 Z30 A10 C-20\nG4 P0.25\nG64 P0.01\n"
    "G93 G1 Z10 A12 C-25 F20.5\nG94 G1 A20 F100\nM5\nM30\n";

std::vector<Block> read(const std::string& text, const MachineModel& machine = test_machine()) {
  std::istringstream in(text);
  const auto blocks = read_canon(in, "canon", machine);
  EXPECT_TRUE(blocks) << (blocks ? "" : blocks.error().message);
  return blocks.value_or(std::vector<Block>{});
}

std::string refusal(const std::string& text, const MachineModel& machine = test_machine()) {
  std::istringstream in(text);
  const auto blocks = read_canon(in, "canon", machine);
  EXPECT_FALSE(blocks) << text;
  return blocks ? "" : blocks.error().message;
}

TEST(Canon, BecomesBlocks) {
  const std::vector<Block> blocks = read(kCanon);
  ASSERT_EQ(blocks.size(), 7U);
  EXPECT_EQ(blocks[0].m_code, 3);
  EXPECT_EQ(blocks[0].spindle, 12000);
  EXPECT_EQ(blocks[1].op, Op::kRapid);
  EXPECT_EQ(blocks[1].target, (Joints{1, 2, 30, 10, -20}));
  EXPECT_TRUE(blocks[1].exact_stop);
  EXPECT_EQ(blocks[2].op, Op::kDwell);
  EXPECT_EQ(blocks[2].feed, 0.25);
  EXPECT_EQ(blocks[3].op, Op::kFeed);
  EXPECT_EQ(blocks[3].feed, 410);
  EXPECT_FALSE(blocks[3].exact_stop);
  EXPECT_EQ(blocks[3].line, 23U);
  EXPECT_EQ(blocks[6].m_code, 2);
}

TEST(Canon, RotaryLettersAndCountingAreTheMachines) {
  MachineModel machine = test_machine();
  machine.tilt.letter = 'B', machine.rotary.letter = 'A';
  EXPECT_EQ(read("1 N..... STRAIGHT_TRAVERSE(1, 2, 3, 4, 5, 6)\n2 N..... PROGRAM_END()\n", machine)[0].target,
            (Joints{1, 2, 3, 5, 4}));
  machine = test_machine();
  machine.rotary.word = RotaryWord::kShortest;
  const auto blocks = read(
      "1 N..... STRAIGHT_TRAVERSE(0, 0, 0, 0, 0, 170)\n2 N..... STRAIGHT_TRAVERSE(0, 0, 0, 0, 0, 350)\n"
      "3 N..... STRAIGHT_TRAVERSE(0, 0, 0, 0, 0, 10)\n4 N..... PROGRAM_END()\n",
      machine);
  EXPECT_EQ(blocks[2].target.c, 370) << "20 degrees on";
}

TEST(Canon, BothReadingsAreExecutedAlike) {
  const MachineModel machine = test_machine();
  std::istringstream text(kProgram);
  const auto program = read_program(text, "part.nc", GcodeReader(machine));
  ASSERT_TRUE(program);
  const auto ours = dry_run(*program, "part.nc", machine, {}, {});
  const auto theirs = dry_run(read(kCanon), "canon", machine, {}, {});
  ASSERT_TRUE(ours && theirs);
  ASSERT_EQ(ours->rows.size(), theirs->rows.size());
  for (std::size_t i = 0; i < ours->rows.size(); ++i) {
    const TraceRow &a = ours->rows[i], &b = theirs->rows[i];
    EXPECT_EQ(a.command.op, b.command.op) << i;
    EXPECT_EQ(a.pose, b.pose) << i;
    EXPECT_NEAR(a.end - a.start, b.end - b.start, 1e-9) << i;
  }
}

// What rs274 prints of G53 G0 Z0, A10 C20, X1 Y2, Z30, a cut and G53 G0 Z0, against our reader of the same
// text.
TEST(Canon, ARetractInMachineCoordinatesIsThatOfTheProgram) {
  const auto traverse = [](const char* to) {
    return "1 N..... STRAIGHT_TRAVERSE(" + std::string(to) + ")\n";
  };
  const std::vector<Block> theirs =
      read(traverse("0, 0, 0, 0, 0, 0") + traverse("0, 0, 0, 10, 0, 20") + traverse("1, 2, 0, 10, 0, 20") +
           traverse("1, 2, 30, 10, 0, 20") + "2 N..... SET_FEED_RATE(100)\n" +
           "3 N..... STRAIGHT_FEED(5, 2, 30, 10, 0, 20)\n" + traverse("5, 2, 0, 10, 0, 20") +
           "4 N..... PROGRAM_END()\n");
  std::istringstream in("G53 G0 Z0\nG0 A10 C20\nG0 X1 Y2\nG0 Z30\nG1 X5 F100\nG53 G0 Z0\nM2\n");
  const auto ours = read_program(in, "p.nc", GcodeReader(test_machine()));
  ASSERT_TRUE(ours) << ours.error().message;
  ASSERT_EQ(theirs.size(), ours->size());
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(theirs[i].target, (*ours)[i].target);
    EXPECT_EQ(theirs[i].placed, (*ours)[i].placed);
    EXPECT_EQ(theirs[i].off_path, (*ours)[i].off_path);
  }
}

TEST(Canon, RefusesByLineAndName) {
  const std::string end = "9 N..... PROGRAM_END()\n", feed = "1 N..... SET_FEED_RATE(5)\n";
  const std::pair<std::string, const char*> cases[] = {
      {"", "without PROGRAM_END"},
      {feed, "without PROGRAM_END"},
      {"hello\n" + end, "canon:1: not a canonical command"},
      {"1 N..... STRAIGHT_FEED(1, 2, 3, 4, 5, 6\n" + end, "canon:1: not a canonical command"},
      {"x N..... ON_RESET()\n" + end, "canon:1: not a canonical command"},
      {"1 N..... STRAIGHT_FEED(1, 2, 3, 4, 5, 6)\n" + end, "before SET_FEED_RATE"},
      {feed + "2 N..... STRAIGHT_FEED(1, 2, 3, 4, 5)\n" + end, "canon:2: STRAIGHT_FEED: a move has six"},
      {feed + "2 N..... STRAIGHT_FEED(1, 2, 3, 4, 5, z)\n" + end, "a number is malformed"},
      {"1 N..... ARC_FEED(1, 2, 3, 4, 1, 6, 0, 0, 0)\n" + end, "ARC_FEED: an arc before SET_FEED_RATE"},
      {feed + "1 N..... ARC_FEED(1, 2, 3, 4, 1, 6, 0, 0, 0)\n" + end, "a place that is not known"},
      {feed + "1 N..... ARC_FEED(1, 2, 3, 4, 2, 6, 0, 0, 0)\n" + end, "more than one turn"},
      {feed + "1 N..... ARC_FEED(1, 2, 3, 4, 1, 6)\n" + end, "nine numbers"},
      {"1 N..... SELECT_PLANE(CANON_PLANE_UV)\n" + end, "no such plane"},
      {"1 N..... USE_LENGTH_UNITS(CANON_UNITS_INCHES)\n" + end, "inches"},
      {"1 N..... SET_G5X_OFFSET(1, 0, 0, 5, 0, 0, 0)\n" + end, "offsets"},
      {"1 N..... USE_TOOL_LENGTH_OFFSET(0 0 90, 0 0 0, 0 0 0)\n" + end, "offsets"},
      {"1 N..... SET_FEED_RATE(-5)\n" + end, "SET_FEED_RATE"}};
  for (const auto& [text, named] : cases) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(named), std::string::npos) << message;
    EXPECT_EQ(message.rfind("canon:", 0), 0U) << message;
  }
  MachineModel machine = test_machine();
  machine.tilt.letter = 'U';
  EXPECT_NE(refusal(end, machine).find("has U"), std::string::npos);
}

TEST(DryRun, NamesTheLineThatLeavesTheTravel) {
  Block far;
  far.line = 17, far.target.z = 501;
  const auto run = dry_run({far}, "part.nc", test_machine(), {}, {});
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, Code::kLimit);
  EXPECT_NE(run.error().message.find("part.nc, line 17: Z"), std::string::npos) << run.error().message;
}

TEST(DryRun, DoesNotWaitAtM0) {
  Block stop, move;
  stop.op = Op::kMCode, stop.m_code = 0, move.target.x = 100;
  const auto run = dry_run({move, stop, stop, move}, "part.nc", test_machine(), {}, {.look_ahead = 2});
  ASSERT_TRUE(run);
  EXPECT_EQ(run->rows.size(), 4U);
  EXPECT_NEAR(run->totals.busy, 0.1, 1e-12);
}

TEST(Canon, ToolsAreThoseOfTheProgram) {
  const std::string move = "N..... STRAIGHT_TRAVERSE(1.0, 2.0, 3.0, 0.0, 0.0, 0.0)\n";
  const auto tools = [&](const std::string& text) {
    std::vector<int> found;
    for (const Block& block : read(text + "9 N..... PROGRAM_END()\n"))
      if (block.op == Op::kRapid) found.push_back(block.tool);
    return found;
  };
  EXPECT_EQ(tools("1 " + move), std::vector<int>{kToolNotSaid});
  // Chosen, and not yet changed: what some controls take at once; the number of a change is a slot's.
  EXPECT_EQ(tools("1 N..... SELECT_TOOL(3)\n2 " + move), std::vector<int>{3});
  EXPECT_EQ(tools("1 N..... SELECT_TOOL(3)\n2 N..... CHANGE_TOOL(17)\n3 " + move +
                  "4 N..... SELECT_TOOL(5)\n5 " + move + "6 N..... CHANGE_TOOL()\n7 " + move),
            (std::vector<int>{3, 3, 5}));
  EXPECT_NE(refusal("1 N..... SELECT_TOOL(-3)\n").find("SELECT_TOOL"), std::string::npos);
}

}  // namespace
}  // namespace tiltfeed::sim
