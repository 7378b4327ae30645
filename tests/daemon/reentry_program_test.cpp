// What a program says of the machine's time, and the program of a re-entry before one of its blocks, read
// back by the simulated machine's reader.

#include <gtest/gtest.h>

#include <sstream>

#include "daemon/journal/reentry.h"
#include "daemon/program/block_cursor.h"
#include "daemon/service/stream_thread.h"
#include "daemon/stream/stream.h"
#include "sim/gcode/gcode_reader.h"
#include "tests/peers/sim_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr const char* kProgram =
    "(TILTFEED part)\nG21 G90 G17 G40 G49 G54\nS8000 M3\nG0 X0 Y0 Z100 A0 C0\nG0 X60 A30 C400\nG0 "
    "Z20\nM8\nG93\n"
    "G1 Z10 F60\nX61 F120\nX62 C401 F120\nX63 F120\nG0 Z100\nG94\nM9\nM5\nM2\n";

TEST(ProgramTime, IsTheMachinesNotTheLines) {
  const Folder folder("reentry");
  const std::string path = folder.write("p.nc", kProgram);
  const auto time = ProgramTime::read(path, LinkKind::kModbusTcp, sim::test_machine());
  ASSERT_TRUE(time) << time.error().message;
  // Rapids at 1000 mm/s and 600 deg/s: 400/600 s, 80 and 90 mm; feeds of 1, 0.5, 0.5 and 0.5 s.
  EXPECT_NEAR(time->total(), 400.0 / 600 + 0.08 + 2.5 + 0.09, 1e-9);
  EXPECT_EQ(time->at(0), 0.0);
  EXPECT_EQ(time->at(1000), time->total());
  const auto block = find_block(path, LinkKind::kModbusTcp, sim::test_machine(), 7);
  ASSERT_TRUE(block);
  EXPECT_EQ(block->text, "X61F120");
  EXPECT_EQ(block->line, 10u);
  EXPECT_EQ(block->moves, 5u);
  EXPECT_NEAR(block->seconds, 400.0 / 600 + 0.08 + 1.5, 1e-9);
  EXPECT_EQ(find_block(path, LinkKind::kGrbl, sim::test_machine(), 7)->text, "G93");
  EXPECT_EQ(find_block(path, LinkKind::kGrbl, sim::test_machine(), 99).error().code, Code::kUsage);
}

TEST(ProgramTime, RemainingTimeFollowsTheMachine) {
  const Folder folder("reentry");
  std::string text = "G90\nG0 X0 Y0 Z0 A0 C0\nG93\n";
  for (int i = 0; i < 1000; ++i) text += "G1 X" + std::to_string(i % 2) + (i < 511 ? " F60\n" : " F20\n");
  const auto time =
      ProgramTime::read(folder.write("p.nc", text + "M2\n"), LinkKind::kModbusTcp, sim::test_machine());
  ASSERT_TRUE(time);
  EXPECT_NEAR(time->total(), 511 + 3 * 489, 1e-6);
  EXPECT_NEAR(remaining_seconds(*time, 512, 0.0, 511.0), 1467,
              0.01);  // half of the lines, a quarter of the time
  EXPECT_NEAR(remaining_seconds(*time, 512, 0.0, 1022.0), 2934,
              0.01);  // the machine takes twice as long as planned
  EXPECT_NEAR(remaining_seconds(*time, 512, 506.0, 900.0), 1467, 0.01);  // too little seen to scale
}

MachineProfile profile() {
  MachineProfile machine;
  machine.model = sim::test_machine();
  return machine;
}

std::vector<sim::Block> read_back(const std::string& text) {
  std::istringstream in(text);
  const auto blocks = sim::read_program(in, "text", 'A', 'C');
  EXPECT_TRUE(blocks) << blocks.error().message;
  return blocks ? *blocks : std::vector<sim::Block>{};
}

/// The text that would be sent.
std::string whole_of(const std::string& path, const Reentry& entry) {
  std::ostringstream out;
  EXPECT_TRUE(write_reentry(path, entry, out));
  return out.str();
}

TEST(Reentry, EndsWhereTheBlockBeforeEndedAndGoesOnAsTheProgram) {
  const Folder folder("reentry");
  const std::string path = folder.write("p.nc", kProgram);
  const std::vector<sim::Block> whole = read_back(kProgram);
  for (std::uint64_t from = 3; from <= whole.size(); ++from) {
    ReentryOptions options;
    options.from = from;
    options.retract = 40.0;
    options.stands = Joints{5, 6, 70, -20, 300};
    const auto entry = plan_reentry(path, LinkKind::kModbusTcp, profile(), options);
    ASSERT_TRUE(entry) << entry.error().message;
    // It can be sent over this link as it is: the first move states every axis.
    EXPECT_TRUE(count_blocks(folder.write("entry.nc", whole_of(path, *entry)), LinkKind::kModbusTcp)) << from;
    const std::vector<sim::Block> again = read_back(whole_of(path, *entry));
    const std::size_t rest = whole.size() - (from - 1);
    ASSERT_GT(again.size(), rest);
    for (std::size_t i = 0; i < rest; ++i) {
      const sim::Block &is = again[again.size() - rest + i], &was = whole[from - 1 + i];
      ASSERT_EQ(is.op, was.op) << from;
      ASSERT_EQ(is.m_code, was.m_code);
      ASSERT_EQ(is.target, was.target) << from << "+" << i;
      ASSERT_EQ(is.feed, was.feed);
      ASSERT_EQ(is.inverse_time, was.inverse_time);
    }
    // Where it stood before, spindle and coolant as they were.
    const sim::Block& last = again[again.size() - rest - 1];
    Joints before;
    bool spindle = false, coolant = false;
    for (std::size_t i = 0; i + 1 < from; ++i) {
      if (whole[i].op == sim::Op::kRapid || whole[i].op == sim::Op::kFeed) before = whole[i].target;
      if (whole[i].op == sim::Op::kMCode) spindle = whole[i].m_code == 3 || (spindle && whole[i].m_code != 5);
      if (whole[i].op == sim::Op::kMCode) coolant = whole[i].m_code == 8 || (coolant && whole[i].m_code != 9);
    }
    EXPECT_EQ(last.target, before) << from;
    bool turns = false;
    for (std::size_t i = 0; i + rest < again.size(); ++i) turns = turns || again[i].m_code == 3;
    EXPECT_EQ(turns, spindle) << from;
    bool flood = false;
    for (std::size_t i = 0; i + rest < again.size(); ++i) flood = flood || again[i].m_code == 8;
    EXPECT_EQ(flood, coolant) << from;
  }
}

TEST(FieldFailures, F19_UnsafeResume) {
  const Folder folder("reentry");
  ReentryOptions options;
  options.from = 10;
  options.retract = 40.0;
  options.plunge_feed = 150.0;
  const std::string path = folder.write("p.nc", kProgram);
  const auto entry = plan_reentry(path, LinkKind::kGrbl, profile(), options);
  ASSERT_TRUE(entry) << entry.error().message;
  // A head tilted by 30 degrees about +X leans the tool towards -Y: 40 (0, -sin 30, cos 30).
  const std::string start =
      "(TILTFEED re-entry before block 10, line 11)\nG21 G90 G17 G40 G49 G54 G94\nG91\nG1 X0 Y-20 Z34.641 "
      "F150\nG90\n";
  ASSERT_EQ(whole_of(path, *entry).substr(0, start.size()), start) << whole_of(path, *entry);
  const std::string rest = whole_of(path, *entry).substr(start.size());
  EXPECT_EQ(
      rest.substr(0, rest.find("G93")),
      "G0 Z134.641\nG0 A30 C400\nG0 X61 Y-20\nS8000 M3\nM8\nG4 P3\nG1 Z44.641 F150\nG1 X61 Y0 Z10 F150\n");
  EXPECT_NE(rest.find("G93\nG1X62C401F120\nX63F120\nG0Z100\n"), std::string::npos) << rest;
  EXPECT_NE(entry->preview.find("1. retract 40 mm"), std::string::npos) << entry->preview;
}

TEST(Reentry, RetractsAlongTheAxisThatTheToolReallyHas) {
  const Folder folder("reentry");
  const std::string path = folder.write("p.nc", kProgram);
  ReentryOptions options;
  options.from = 10;
  options.retract = 40.0;
  options.stands = Joints{5, 6, 70, -30, 300};
  // A head tilted by 30 degrees about -X leans the tool towards +Y: 40 (0, sin 30, cos 30).
  const auto relative = plan_reentry(path, LinkKind::kGrbl, profile(), options);
  ASSERT_TRUE(relative) << relative.error().message;
  EXPECT_NE(relative->head.find("G91\nG1 X0 Y20 Z34.641 F200\nG90\n"), std::string::npos) << relative->head;
  EXPECT_NE(relative->preview.find("X5 Y6 Z70 A-30 C300"), std::string::npos) << relative->preview;
  const auto absolute = plan_reentry(path, LinkKind::kModbusTcp, profile(), options);
  ASSERT_TRUE(absolute) << absolute.error().message;
  EXPECT_NE(absolute->head.find("\nG1 X5 Y26 Z104.641 A-30 C300 F200\n"), std::string::npos)
      << absolute->head;
  // High above the program already: never down.
  options.stands = Joints{5, 6, 400, 0, 300};
  const auto high = plan_reentry(path, LinkKind::kModbusTcp, profile(), options);
  ASSERT_TRUE(high) << high.error().message;
  EXPECT_NE(high->head.find("G0 Z440\n"), std::string::npos) << high->head;
  // A controller that does not say where it stands.
  options.stands.reset();
  const auto blind = plan_reentry(path, LinkKind::kModbusTcp, profile(), options);
  ASSERT_FALSE(blind);
  EXPECT_NE(blind.error().message.find("does not report"), std::string::npos);
}

TEST(Reentry, RefusesWhatItCannotVouchFor) {
  const Folder folder("reentry");
  const std::string path = folder.write("p.nc", kProgram);
  ReentryOptions options;
  options.stands = Joints{0, 0, 0, 0, 0};
  const auto code = [&](const std::string& file) {
    const auto entry = plan_reentry(file, LinkKind::kModbusTcp, profile(), options);
    return entry ? Code::kCancelled : entry.error().code;
  };
  for (const std::uint64_t from : {0, 1, 2, 99}) {
    options.from = from;
    EXPECT_EQ(code(path), Code::kUsage) << from;
  }
  options.from = 6;
  EXPECT_EQ(code(folder.write("arc.nc", std::string(kProgram) + "")), Code::kCancelled);
  EXPECT_EQ(
      code(folder.write("bad.nc", "G90\nG0 X0 Y0 Z0 A0 C0\nG2 X1 I1\nG0 X2\nG0 X3\nG0 X4\nG0 X5\nG0 X6\n")),
      Code::kInput);
  EXPECT_EQ(code(folder.write("far.nc", "G90\nG0 X0 Y-490 Z0 A80 C0\nG0 X2\nG0 X3\nG0 X4\nG0 X5\nG0 X6\n")),
            Code::kLimit);
}

}  // namespace
}  // namespace tiltfeed
