// What a program says of the machine's time, and the program of a re-entry before one of its blocks, read
// back by the simulated machine's reader.

#include <gtest/gtest.h>

#include <sstream>

#include "daemon/journal/reentry.h"
#include "daemon/journal/tool_return.h"
#include "daemon/program/block_cursor.h"
#include "daemon/program/tool_change.h"
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
      "G0 Z134.641\nG0 A30 C400\nG0 X61 Y-20\nS8000 M3\nM8\nG4 P3\nG1 Z44.641 F150\nG1 X61 Y0 Z10 F150\nG1 "
      "F150\n");
  EXPECT_NE(rest.find("G93\nX62C401F120\nX63F120\nG0Z100\n"), std::string::npos) << rest;
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
  // Its words are by how much, and look like a place otherwise.
  EXPECT_NE(relative->preview.find("by these words (G91)"), std::string::npos) << relative->preview;
  const auto absolute = plan_reentry(path, LinkKind::kModbusTcp, profile(), options);
  ASSERT_TRUE(absolute) << absolute.error().message;
  EXPECT_EQ(absolute->preview.find("(G91)"), std::string::npos) << absolute->preview;
  EXPECT_NE(absolute->head.find("\nG1 X5 Y26 Z104.641 A-30 C300 F200\n"), std::string::npos)
      << absolute->head;
  // Who holds it against bodies is told places over every link, the first at feed.
  for (const auto& one : {*relative, *absolute})
    EXPECT_EQ(one.from, "G1 X5 Y6 Z70 A-30 C300 F200\nG1 X5 Y26 Z104.641 A-30 C300 F200\n");
  EXPECT_EQ(relative->held,
            "G0 X5 Y26 Z104.641 A-30 C300\nG0 Z134.641\nG0 A30 C400\nG0 X61 Y-20\nG1 Z44.641 F200\n"
            "G1 X61 Y0 Z10 F200\n");
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

/// As a machine reads it that knows where its own places are.
std::vector<sim::Block> read_on_machine(const std::string& text) {
  sim::GcodeReader reader(sim::test_machine());
  std::istringstream in(text);
  std::vector<sim::Block> blocks;
  for (std::string line; std::getline(in, line);) {
    const auto read = reader.read_line(line, blocks);
    EXPECT_TRUE(read) << line << ": " << read.error().message;
  }
  return blocks;
}

Joints place_after(const std::vector<sim::Block>& blocks, std::size_t count) {
  Joints at;
  for (std::size_t i = 0; i < count; ++i)
    if (blocks[i].op == sim::Op::kRapid || blocks[i].op == sim::Op::kFeed) at = blocks[i].target;
  return at;
}

/// After G53 the axes are not where the last program words led: entering there would plunge into the part
/// and cross it at rapid.
TEST(Reentry, B11GoesToTheMachinesOwnPlaceWhereTheProgramHasSentAnAxisThere) {
  const std::string text =
      "G21 G90\nG0 X0 Y0 Z50 A10 C20\nS8000 M3\nG1 Z10 F100\nX50 F200\nG53 G0 Z0\nG0 X70 Y5\nG0 C90\n"
      "G0 Z20\nG1 Z5\nX60\n";
  const Folder folder("reentry");
  const std::string path = folder.write("p.nc", text);
  const std::vector<sim::Block> whole = read_on_machine(text);
  EXPECT_EQ(place_after(whole, 6).z, sim::test_machine().z.max);
  ReentryOptions options;
  options.stands = Joints{5, 6, 70, 0, 0};
  for (const LinkKind kind : {LinkKind::kGrbl, LinkKind::kModbusTcp, LinkKind::kRepRap})
    for (std::uint64_t from = 3; from <= whole.size(); ++from) {
      options.from = counts_numeric_blocks(kind) ? from : from + 1;  // the line of G21 is no block
      const auto entry = plan_reentry(path, kind, profile(), options);
      ASSERT_TRUE(entry) << entry.error().message;
      std::string program = whole_of(path, *entry);
      if (const auto relative = program.find("G91\n"); relative != program.npos)
        program.replace(relative, program.find("G90\n", relative) - relative,
                        "G1 X5 Y6 Z100 A0 C0 F1\n");  // the sim's reader wants places
      if (const auto dwell = program.find("G4 S"); dwell != program.npos) program[dwell + 3] = 'P';
      const std::vector<sim::Block> again = read_on_machine(program);
      const std::size_t rest = whole.size() - (from - 1);
      ASSERT_GT(again.size(), rest);
      EXPECT_EQ(place_after(again, again.size() - rest), place_after(whole, from - 1)) << from << "\n"
                                                                                       << program;
      EXPECT_EQ(again.back().target, whole.back().target);
    }
}

/// In inverse time Grbl refuses a G1 without F (error 22), and RepRap takes the M8 of "G1M8" for a parameter.
TEST(Reentry, B11NoWordIsGluedToTheFirstLine) {
  const Folder folder("reentry");
  const std::string text =
      "G21 G90\nG0 X0 Y0 Z50 A10 C20\nG1 Z10 F100\nG93\nX50 F60\nm8\nT3\nS900 M3\nX60 F60\nM6\nG94\nM9\n"
      "F250\nX70\nF600 G94 X80\n";
  const std::string path = folder.write("p.nc", text);
  ReentryOptions options;
  options.stands = Joints{5, 6, 70, 0, 0};
  const auto tail = [&](std::uint64_t from, LinkKind kind = LinkKind::kGrbl) {
    options.from = from;
    const auto entry = plan_reentry(path, kind, profile(), options);
    EXPECT_TRUE(entry) << entry.error().message;
    return entry ? entry->head.substr(entry->head.rfind("G1 X")) : "";
  };
  EXPECT_EQ(tail(5), "G1 X0 Y0 Z10 F200\nG1 F200\nG93\nX50F60\n");
  for (const LinkKind kind : {LinkKind::kGrbl, LinkKind::kRepRap})
    EXPECT_EQ(tail(6, kind), "G1 X50 Y0 Z10 F200\nG1 F200\nG93\nM8\n");
  // A tool that is chosen long before the M6 that takes it, and forgotten after it.
  EXPECT_EQ(tail(8), "G1 X50 Y0 Z10 F200\nG1 F200\nG93\nT3\nS900M3\n");
  EXPECT_EQ(tail(10), "G1 X60 Y0 Z10 F200\nG1 F200\nG93\nT3\nM6\n");
  EXPECT_EQ(tail(11), "G1 X60 Y0 Z10 F200\nG1 F200\nG93\nG94\n");
  EXPECT_EQ(tail(12), "G1 X60 Y0 Z10 F200\nG1 F200\nM9\n");
  EXPECT_EQ(tail(14), "G1 X60 Y0 Z10 F200\nG1 F250\nX70\n");
}

/// A tool change after the entry is named, and held against the length in the program's words, as before.
TEST(Reentry, B11KeepsWhatTheCommentsSayOfTools) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    std::string text =
        "G21 G90\nG0 X0 Y0 Z50 A10 C20\nG1 Z10 F100\nX1\n(TILTFEED tool length 80.25 mm is in the words)\n"
        "T2 M6 (drill (5)\nX2\n; TILTFEED tool length 70 mm is in the words\n\nT3 ; ball (6 mm)\nM0\nX3\nM2\n"
        "!behind the end\n";
    for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += end.size())
      text.replace(at, 1, end);
    const Folder folder("reentry");
    const std::string path = folder.write("p.nc", text);
    const auto axes = numeric_axes(sim::test_machine());
    const auto whole = read_tool_changes(path, LinkKind::kGrbl, axes);
    ASSERT_TRUE(whole && whole->size() == 2) << whole.error().message;
    EXPECT_EQ((*whole)[0].length, 80.25);
    EXPECT_EQ((*whole)[1].length, 70.0);
    EXPECT_EQ((*whole)[1].name, "ball (6 mm)");
    ReentryOptions options;
    options.stands = Joints{5, 6, 70, 0, 0};
    for (std::uint64_t from = 4; from <= 10; ++from) {
      options.from = from;
      const auto entry = plan_reentry(path, LinkKind::kGrbl, profile(), options);
      ASSERT_TRUE(entry) << entry.error().message;
      // No tool is changed on the way in: the operator is told which one it must be.
      const std::string tool = from <= 5   ? ""
                               : from <= 8 ? "0. in the spindle must be: T2 (drill (5), 80.25 mm long\n"
                                           : "0. in the spindle must be: T3 (ball (6 mm)), 70 mm long\n";
      EXPECT_EQ(entry->preview.substr(0, tool.size()), tool) << from << entry->preview;
      EXPECT_EQ(entry->preview.find("in the spindle") == std::string::npos, tool.empty()) << from;
      std::string program = whole_of(path, *entry);
      program.erase(program.find("G91\n"), 4);  // a reader of changes wants places
      const auto again = read_tool_changes(folder.write("again.nc", program), LinkKind::kGrbl, axes);
      ASSERT_TRUE(again) << again.error().message << program;
      const std::size_t left = from <= 5 ? 2 : from <= 8 ? 1 : 0;
      ASSERT_EQ(again->size(), left) << from << program;
      for (std::size_t i = 0; i < left; ++i) {
        const ToolChange &is = (*again)[i], &was = (*whole)[2 - left + i];
        EXPECT_EQ(is.tool, was.tool);
        EXPECT_EQ(is.length, was.length) << from << program;
        EXPECT_EQ(is.name.substr(0, 4), was.name.substr(0, 4)) << from << program;
      }
    }
  }
}

/// Of the program that a re-entry has written everything can be asked that can be asked of the job's own.
TEST(Reentry, B11CanBeEnteredAgainAndGoesThroughToolChanges) {
  const Folder folder("reentry");
  const std::string text =
      "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S900\nG1 X5 F100\nX6\nX7\nT2\nM6\nG1X8F100\nX9\nM2\n";
  const std::string path = folder.write("p.nc", text);
  for (const LinkKind kind : {LinkKind::kGrbl, LinkKind::kRepRap})
    for (const bool stands : {false, true}) {
      ReentryOptions options;
      options.from = 5;
      if (stands) options.stands = Joints{5, 0, 70, -20, 0};
      const auto first = plan_reentry(path, kind, profile(), options);
      ASSERT_TRUE(first) << first.error().message;
      const std::string once = folder.write("once.nc", whole_of(path, *first));
      const auto changes = read_tool_changes(once, kind, numeric_axes(profile().model));
      ASSERT_TRUE(changes) << changes.error().message;
      ASSERT_EQ(changes->size(), 1u);
      EXPECT_EQ((*changes)[0].tool, 2);
      EXPECT_EQ(first->preview.find("in the spindle"), std::string::npos) << "it is the one of the start";
      // Behind the change, and behind a re-entry of that: the same tool.
      options.from = 9;
      const auto behind = plan_reentry(path, kind, profile(), options);
      ASSERT_TRUE(behind) << behind.error().message;
      EXPECT_NE(behind->preview.find("in the spindle must be: T2\n"), std::string::npos) << behind->preview;
      const std::string rest = folder.write("rest.nc", whole_of(path, *behind));
      options.from = count_blocks(rest, kind).value();
      const auto deeper = plan_reentry(rest, kind, profile(), options);
      ASSERT_TRUE(deeper) << deeper.error().message;
      EXPECT_NE(deeper->preview.find("in the spindle must be: T2\n"), std::string::npos) << deeper->preview;
      ReturnOptions back;
      back.change = (*changes)[0].block;
      const auto way = plan_return(once, kind, profile(), back);
      ASSERT_TRUE(way) << way.error().message;
      EXPECT_NE(way->program.find("X7"), std::string::npos) << way->program;
      EXPECT_TRUE(ProgramTime::read(once, kind, profile().model));
      // The block after the one that was entered first: again the same rest.
      options.from = count_blocks(once, kind).value() - (count_blocks(path, kind).value() - 6);
      const auto again = plan_reentry(once, kind, profile(), options);
      ASSERT_TRUE(again) << again.error().message;
      EXPECT_EQ(whole_of(once, *again).substr(whole_of(once, *again).find("\nX7\n")),
                text.substr(text.find("\nX7\n")));
      // On the relative retract itself there is nothing to stand on.
      options.from = 6;
      EXPECT_FALSE(plan_reentry(once, kind, profile(), options));
    }
}

TEST(Reentry, B11SaysWhichAxisTheProgramHasNotNamedYet) {
  const Folder folder("reentry");
  const std::string path = folder.write("p.nc", "G21\nG0 X0 Y0\nG0 Z5 A0\nG0 C0\nG1 X5 F100\n");
  ReentryOptions options;
  options.stands = Joints{};
  const auto why = [&](std::uint64_t from) {
    options.from = from;
    const auto entry = plan_reentry(path, LinkKind::kGrbl, profile(), options);
    return entry ? "" : entry.error().message;
  };
  EXPECT_NE(why(2).find("no axis has moved"), std::string::npos) << why(2);
  EXPECT_NE(why(3).find("has not said where ZAC are"), std::string::npos) << why(3);
  EXPECT_NE(why(4).find("has not said where C is"), std::string::npos) << why(4);
  EXPECT_EQ(why(5), "");
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

/// A quarter round in X Y, one over the top in Z X, and one that only goes on with the G2 of the line before.
constexpr const char* kArcs =
    "G21 G90 G17 G40 G49 G54\nG0 X0 Y0 Z100 A0 C0\nG0 Z20\nG94\nG1 Z10 F600\nG3 X10 Y10 I0 J10 F600\nG18\n"
    "G2 X0 Z20 I-10 K0\nX-10 Z10 I0 K-10\nG93\nG3 X0 Z20 I10 K0 F30\nG1 X5 F60\nG17\nG0 Z100\nG94\nM2\n";
constexpr double kQuarter = 15.707963267948966;  // of a circle of 10 mm, mm

TEST(ProgramTime, AnArcTakesTheTimeOfItsWay) {
  const Folder folder("reentry");
  const std::string path = folder.write("arcs.nc", kArcs);
  const auto seconds = [&](std::uint64_t block) {
    const auto found = find_block(path, LinkKind::kGrbl, sim::test_machine(), block);
    EXPECT_TRUE(found) << found.error().message;
    return found ? found->seconds : 0.0;
  };
  EXPECT_NEAR(seconds(6) - seconds(5), kQuarter / 10.0, 1e-9);
  EXPECT_NEAR(seconds(8) - seconds(7), kQuarter / 10.0, 1e-9);
  EXPECT_NEAR(seconds(11) - seconds(10), 2.0, 1e-9) << "inverse time";
}

TEST(ProgramTime, NoArcGoesAsANumericBlock) {
  const Folder folder("reentry");
  const auto time =
      ProgramTime::read(folder.write("arcs.nc", kArcs), LinkKind::kModbusTcp, sim::test_machine());
  ASSERT_FALSE(time);
  EXPECT_NE(time.error().message.find("arcs.nc:6"), std::string::npos) << time.error().message;
  EXPECT_NE(time.error().message.find("post without arcs (program.arc_tolerance_mm"), std::string::npos)
      << time.error().message;
}

TEST(ReentryProgram, EntersAtAnArcInItsPlane) {
  const Folder folder("reentry");
  const std::string path = folder.write("arcs.nc", kArcs);
  ReentryOptions options;
  options.retract = 5.0;
  for (const std::uint64_t from : {6u, 8u, 11u, 12u}) {
    SCOPED_TRACE(from);
    options.from = from;
    const auto entry = plan_reentry(path, LinkKind::kGrbl, profile(), options);
    ASSERT_TRUE(entry) << entry.error().message;
    std::ostringstream text;
    ASSERT_TRUE(write_reentry(path, *entry, text));
    std::istringstream whole(kArcs), again(text.str());
    const auto all = sim::read_program(whole, "all", 'A', 'C');
    sim::GcodeReader reader = sim::GcodeReader('A', 'C').with_relative();
    const auto some = sim::read_program(again, "some", reader);
    ASSERT_TRUE(all) << all.error().message;
    ASSERT_TRUE(some) << some.error().message << text.str();
    // The end of both programs is the same, arcs piece by piece.
    const auto last = [&](const std::vector<sim::Block>& blocks, std::size_t k) {
      return blocks[blocks.size() - 1 - k];
    };
    const std::size_t count = from == 12 ? 2 : 30;
    for (std::size_t k = 0; k < count; ++k) {
      EXPECT_EQ(last(*all, k).target, last(*some, k).target) << k;
      EXPECT_EQ(last(*all, k).feed, last(*some, k).feed) << k;
    }
  }
}

/// The entry is over the highest place of the program: that of an arc may be between its ends.
TEST(ReentryProgram, GoesOverTheTopOfAnArc) {
  const Folder folder("reentry");
  const std::string path = folder.write(
      "bow.nc", "G21 G90 G17\nG0 X0 Y0 Z5 A0 C0\nG94\nG1 X1 F600\nG18\nG2 X-19 I-10 K0\nG1 X-20\nM2\n");
  ReentryOptions options;
  options.retract = 2.0;
  options.from = 7;
  const auto entry = plan_reentry(path, LinkKind::kGrbl, profile(), options);
  ASSERT_TRUE(entry) << entry.error().message;
  EXPECT_NE(entry->head.find("G0 Z17"), std::string::npos) << entry->head;  // 5 + 10 + 2
}

TEST(ReentryProgram, AnArcThatGoesOnWithTheLineBeforeIsNoEntry) {
  const Folder folder("reentry");
  ReentryOptions options;
  options.from = 9;
  const auto entry = plan_reentry(folder.write("arcs.nc", kArcs), LinkKind::kGrbl, profile(), options);
  ASSERT_FALSE(entry);
  EXPECT_EQ(entry.error().code, Code::kUsage);
  EXPECT_NE(entry.error().message.find("without a G2 or G3 of its own"), std::string::npos)
      << entry.error().message;
}

}  // namespace
}  // namespace tiltfeed
