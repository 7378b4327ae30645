// CL text -> program -> the tool path that it really makes, in every dialect and on every machine that is
// shipped: the way back must be the way there.

#include "daemon/post/post.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "tests/judges/dialect_reader.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

/// Every point that the program makes lies on the path (tip on its segments, in order), and every point of
/// the path is passed with its axis.
void expect_same_way(const AptOperation& want, const AptOperation& got, double tip, double axis_deg) {
  const double axis = Angle::from_degrees(axis_deg).radians();
  std::size_t at = 0;
  for (std::size_t i = 0; i < want.path.moves.size(); ++i) {
    const Pose& target = want.path.moves[i].pose;
    std::size_t found = at;
    while (found < got.path.moves.size() &&
           (distance(got.path.moves[found].pose.tip, target.tip) > tip ||
            angle_between(got.path.moves[found].pose.axis, target.axis) > axis))
      ++found;
    ASSERT_LT(found, got.path.moves.size()) << "move " << i << " is not made";
    if (i > 0)
      for (std::size_t k = at; k <= found; ++k) {
        const Pose &p = want.path.moves[i - 1].pose, &pose = got.path.moves[k].pose;
        const double rapid = got.path.moves[k].kind == MoveKind::kRapid ? kRapidToleranceFactor : 1.0;
        ASSERT_LE(distance_to_segment(pose.tip, p.tip, target.tip), tip * rapid) << "point " << k;
        ASSERT_LE(angle_between(p.axis, pose.axis) + angle_between(pose.axis, target.axis),
                  angle_between(p.axis, target.axis) + 2.0 * axis * rapid)
            << "point " << k;
      }
    at = found;
  }
}

TEST(PostWords, CoolantThroughTheSpindleIsTheProfilesWord) {
  const std::string text =
      "UNITS/MM\nLOADTL/3,LENGTH,80\nSPINDL/900,RPM,CLW\nCOOLNT/THRU\nRAPID\nGOTO/0,0,20,0,0,1\nFEDRAT/"
      "400,MMPM\n"
      "GOTO/0,0,0\nCOOLNT/FLOOD\nGOTO/9,0,0\nCOOLNT/OFF\nFINI\n";
  std::istringstream in(text);
  const auto stated = read_apt(in, "in.cls", {});
  ASSERT_TRUE(stated);
  EXPECT_TRUE(stated->notes.empty()) << stated->notes.front();
  const auto refused = program_text(*stated, machine(Dialect::kSiemens, false), setup());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("in.cls:6: COOLNT/THRU"), std::string::npos)
      << refused.error().message;
  EXPECT_NE(refused.error().message.find("generic-ac.yaml has no words for coolant through"),
            std::string::npos)
      << refused.error().message;
  const MachineProfile haas = machine(Dialect::kHaas, false);
  const auto posted = program_text(*stated, haas, setup());
  ASSERT_TRUE(posted) << posted.error().message;
  EXPECT_NE(posted->find("\nM88\n"), std::string::npos) << *posted;
  EXPECT_NE(posted->find("\nM89\nM8\n"), std::string::npos) << *posted;
  const auto read = back(*posted, haas);
  ASSERT_TRUE(read) << read.error().message;
  std::vector<double> coolant;
  for (const PathEvent& event : read->operations[0].events)
    if (event.kind == EventKind::kCoolant) coolant.push_back(event.value);
  EXPECT_EQ(coolant, (std::vector<double>{3.0, 1.0, 0.0}));
}

TEST(PostWords, BlendsWhereNoRotaryTurnsAndLeavesItItsShare) {
  std::string text = "UNITS/MM\nLOADTL/3,LENGTH,80\nRAPID\nGOTO/0,0,20,0,0,1\nFEDRAT/400,MMPM\n";
  for (int k = 0; k < 60; ++k) {
    const bool leans = k >= 20 && k < 40;
    text += "GOTO/" + std::to_string(k / 2) + "," + std::to_string((k + 1) / 2 + k % 3) + ",0," +
            (leans && k != 30 ? "0.6,0,0.8"
             : leans          ? "0.28,0,0.96"
                              : "0,0,1") +
            "\n";
  }
  std::istringstream in(text + "FINI\n");
  const auto stated = read_apt(in, "in.cls", {});
  ASSERT_TRUE(stated);
  MachineProfile profile = machine(Dialect::kRs274, false, "linuxcnc-bridge-bc");
  profile.format.path_control = PathControl::kBlend;
  profile.format.blend_tolerance = 0.004;
  PostOptions options;
  options.tolerance = 0.004;
  const auto none_left = program_text(*stated, profile, options);
  ASSERT_FALSE(none_left);
  EXPECT_NE(none_left.error().message.find("--arc-tolerance take all"), std::string::npos);
  options.tolerance = 0.02;
  const auto posted = program_text(*stated, profile, options);
  ASSERT_TRUE(posted) << posted.error().message;
  // The text alone: under G64 neither a block nor the next one nor the one before states another rotary word.
  std::istringstream lines(*posted);
  bool blends = false, turned = false;
  int blended = 0, switches = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("G64")) {
      EXPECT_EQ(line, "G64 P0.0032");
    }
    if (line.starts_with("G64") || line.starts_with("G61")) blends = line[2] == '4', ++switches;
    if (line.starts_with("(") || line.find_first_of("XYZBC") == line.npos) continue;
    const bool turns = line.find_first_of("BC") != line.npos;
    EXPECT_FALSE(blends && (turns || turned)) << line;
    turned = turns;
    blended += blends;
  }
  EXPECT_FALSE(blends) << "the program ends in exact stop";
  EXPECT_GE(switches, 5) << *posted;
  EXPECT_GE(blended, 30);
  profile.format.path_control = PathControl::kExact;
  profile.format.blend_tolerance = 0.0;
  options.tolerance = 0.016;
  auto exact = program_text(*stated, profile, options);
  ASSERT_TRUE(exact);
  const auto without = [](std::string program_lines) {
    std::istringstream all(program_lines);
    std::string kept;
    for (std::string line; std::getline(all, line);)
      if (!line.starts_with("G6") && !line.starts_with("(")) kept += line + "\n";
    return kept;
  };
  EXPECT_EQ(without(*posted), without(*exact)) << "the words are those of a tolerance of 0.016 mm";
  EXPECT_TRUE(back(*posted, profile));
}

class Posts : public testing::TestWithParam<DialectCase> {};
INSTANTIATE_TEST_SUITE_P(All, Posts, testing::ValuesIn(dialect_cases()), case_name);

TEST_P(Posts, TheProgramMakesThePath) {
  const MachineProfile profile = machine(GetParam().dialect, GetParam().tcp);
  const PostOptions options = setup();
  const auto text = program_text(foreign(), profile, options);
  ASSERT_TRUE(text) << text.error().message;
  const auto made = back(*text, profile);
  ASSERT_TRUE(made) << made.error().message;
  const AptProgram want = foreign();
  ASSERT_EQ(made->operations.size(), want.operations.size());
  for (std::size_t k = 0; k < want.operations.size(); ++k) {
    const AptOperation &there = want.operations[k], &here = made->operations[k];
    EXPECT_EQ(here.tool_number, there.tool_number);
    EXPECT_EQ(here.path.tool.length, there.path.tool.length);
    // Three decimals may round the tip by 0.0009 mm and, through the lever of the tool, by the rotaries' as
    // much.
    expect_same_way(there, here, options.tolerance + 0.003, 0.06);
    EXPECT_EQ(here.events.front().kind, EventKind::kSpindle);
    EXPECT_EQ(here.events.front().value, k == 0 ? 12000.0 : -8000.0);
  }
  // The feed of the tip on the second tool's cut: 20 inches a minute.
  const ToolPath& last = made->operations[1].path;
  for (std::size_t i = 0; i < last.moves.size(); ++i) {
    const bool long_cut = i > 1 && last.moves[i].kind == MoveKind::kCut &&
                          distance(last.moves[i].pose.tip, last.moves[i - 1].pose.tip) > 1.0;
    EXPECT_TRUE(!long_cut || std::abs(feed_of(last, i).mm_per_min() / 508.0 - 1.0) < 0.01) << i;
  }
}

TEST(Post, TheHeadersTimeHasAccelerationsAndStops) {
  // To and fro: from rest to rest d / v + v / a each, where the feed alone would need d / v.
  constexpr double kWay = 10.0, kFeed = 6000.0;
  constexpr int kWays = 20;
  std::string cls = "UNITS/MM\nCUTTER/6\nLOADTL/1,LENGTH,100\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/6000,MMPM\n";
  for (int i = 1; i <= kWays; ++i) cls += i % 2 != 0 ? "GOTO/10,0,50,0,0,1\n" : "GOTO/0,0,50,0,0,1\n";
  std::istringstream in(cls + "FINI\n");
  const auto program = read_apt(in, "in.cls", {});
  ASSERT_TRUE(program) << program.error().message;
  const MachineProfile profile = machine(Dialect::kRs274, false);
  const auto text = program_text(*program, profile, setup());
  ASSERT_TRUE(text) << text.error().message;
  const std::size_t at = text->find(" time ");
  ASSERT_NE(at, text->npos);
  const double v = kFeed / 60.0, a = profile.model.x.acceleration;
  EXPECT_NEAR(std::stod(text->substr(at + 6)), kWays * (kWay / v + v / a), 0.11) << *text;
}

TEST(Post, EveryShippedMachineMakesThePath) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SOURCE_DIR "/config/machines")) {
    const std::string name = entry.path().stem().string();
    for (const bool tcp : {false, true}) {
      SCOPED_TRACE(name + (tcp ? " TCP" : ""));
      // Words whose sign is the way are no Sinumerik's.
      const bool is_signed = name == "vmc-bhead-bc";
      const MachineProfile profile = machine(is_signed ? Dialect::kFanuc : Dialect::kSiemens, tcp, name);
      PostOptions options;
      options.setup.part_zero = {0, 0, 20};
      AptProgram want = foreign();
      const auto text = program_text(want, profile, options);
      // A machine may be too small for this part: then it must say so, with the line.
      if (!text) {
        EXPECT_NE(text.error().message.find("in.cls:"), std::string::npos) << text.error().message;
        continue;
      }
      const auto made = back(*text, profile);
      ASSERT_TRUE(made) << made.error().message;
      for (std::size_t k = 0; k < want.operations.size(); ++k)
        expect_same_way(want.operations[k], made->operations[k], options.tolerance + 0.003, 0.06);
      ++count;
    }
  }
  EXPECT_GE(count, 6) << "machines that could make it";
}

TEST(Post, AWrongProgramMakesAnotherPath) {
  const MachineProfile profile = machine(Dialect::kRs274, false);
  const auto text = program_text(foreign(), profile, setup());
  ASSERT_TRUE(text);
  UnpostOptions longer;
  longer.tool_length = 101.0;
  const auto made = back(*text, profile, longer);
  ASSERT_TRUE(made);
  double worst = 0.0;
  const AptProgram want = foreign();
  for (const Move& move : want.operations[0].path.moves) {
    double least = 1e9;
    for (const Move& one : made->operations[0].path.moves)
      least = std::min(least, distance(one.pose.tip, move.pose.tip));
    worst = std::max(worst, least);
  }
  EXPECT_GT(worst, 0.05) << "a tool length that is wrong by 1 mm must show where the tool leans";
}

TEST(Post, TheFeedOfEachMoveIsThatOfTheFile) {
  // On a still axis the block time is way / feed, so F tells the feed.
  std::istringstream in(
      "LOADTL/1,LENGTH,50\nGOTO/0,0,10\nFEDRAT/100\nGOTO/0,0,0\nFEDRAT/250\nGOTO/10,0,0\n"
      "FEDRAT/777\nGOTO/10,10,0\nFEDRAT/100\nGOTO/0,10,0\nFINI\n");
  const auto program = read_apt(in, "in.cls", {});
  ASSERT_TRUE(program) << program.error().message;
  const auto text = program_text(*program, machine(Dialect::kRs274, false), {});
  ASSERT_TRUE(text);
  const SeenProgram seen = seen_program(*text, false, 'A', 'C');
  ASSERT_EQ(seen.blocks.size(), 5u);
  const double feeds[]{0, 10, 25, 77.7, 10};
  for (std::size_t i = 1; i < 5; ++i) EXPECT_NEAR(seen.blocks[i].feed, feeds[i], 1e-3) << i;
}

/// Axes on a cone about the pole, `turns` times round, the feed changing on the way, a stop in the middle.
AptProgram winding(double turns) {
  std::ostringstream text;
  text << "LOADTL/2,LENGTH,60\nRAPID\nGOTO/30,0,20,0.2588190451,0,0.9659258263\nFEDRAT/200\n";
  const int count = static_cast<int>(turns * 60);
  for (int k = 0; k <= count; ++k) {
    const double f = 2 * kPi * turns * k / count, s = std::sin(kPi / 12);
    if (k == 1) text << "FEDRAT/900\n";
    if (k == count / 2) text << "STOP\nFEDRAT/750\n";
    char line[160];
    std::snprintf(line, sizeof line, "GOTO/%.6f,%.6f,0,%.10f,%.10f,%.10f\n", 30 * std::cos(f),
                  30 * std::sin(f), s * std::cos(f), s * std::sin(f), std::cos(kPi / 12));
    text << line;
  }
  text << "FINI\n";
  std::istringstream in(text.str());
  const auto program = read_apt(in, "in.cls", {});
  EXPECT_TRUE(program) << program.error().message;
  return *program;
}

TEST(Post, TurnsARotaryBackOverTheClearHeight) {
  MachineProfile profile = machine(Dialect::kRs274, false);
  profile.model.rotary.min = -400, profile.model.rotary.max = 400;
  const AptProgram want = winding(4.0);
  PostOptions options;
  const auto refused = program_text(want, profile, options);
  ASSERT_FALSE(refused) << "four turns within 800 degrees";
  EXPECT_EQ(refused.error().message.rfind("in.cls:", 0), 0u) << refused.error().message;
  options.clear.height = 40.0;
  const auto posted = post(want, "in.cls", profile, options);
  ASSERT_TRUE(posted) << posted.error().message;
  EXPECT_GE(posted->report.reconfigurations, 1u);
  std::ostringstream text;
  ASSERT_TRUE(write_program(posted->posting, text));
  const auto made = back(text.str(), profile);
  ASSERT_TRUE(made) << made.error().message;
  const AptOperation &there = want.operations[0], &here = made->operations[0];
  // Every pose in order, at the feed of the file, and the stop just before its move.
  std::size_t at = 0;
  for (std::size_t i = 0; i < there.path.moves.size(); ++i) {
    const Pose& target = there.path.moves[i].pose;
    const auto reached = [&](const Pose& pose) {
      return distance(pose.tip, target.tip) < 0.008 && angle_between(pose.axis, target.axis) < 0.002;
    };
    while (at < here.path.moves.size() && !reached(here.path.moves[at].pose)) ++at;
    ASSERT_LT(at, here.path.moves.size()) << "move " << i;
    if (i > 1 && here.path.moves[at].kind != MoveKind::kRapid) {
      EXPECT_NEAR(feed_of(here.path, at).mm_per_min(), feed_of(there.path, i).mm_per_min(),
                  0.01 * feed_of(there.path, i).mm_per_min())
          << "move " << i;
    }
    for (const PathEvent& event : there.events)
      if (event.kind == EventKind::kStop && event.move == i) {
        bool found = false;
        for (const PathEvent& seen : here.events)
          found = found || (seen.kind == EventKind::kStop && seen.move <= at && at < seen.move + 40);
        EXPECT_TRUE(found) << "the stop before move " << i;
      }
  }
  // The tool is set down again at the first feed of the file, and turned where nothing stands.
  double turned_low = 0.0, set_down = 1e9;
  for (std::size_t i = 1; i < here.path.moves.size(); ++i) {
    const Pose &p = here.path.moves[i - 1].pose, &q = here.path.moves[i].pose;
    const bool rapid = here.path.moves[i].kind == MoveKind::kRapid;
    if (rapid && q.tip.z < 39.9) turned_low = std::max(turned_low, angle_between(p.axis, q.axis));
    if (!rapid && q.tip.z < p.tip.z - 0.5 && i > 40)
      set_down = std::min(set_down, feed_of(here.path, i).mm_per_min());
  }
  EXPECT_LT(turned_low, 0.002);
  EXPECT_NEAR(set_down, 200.0, 2.0);
}

TEST(Post, ComesFromAndLeavesToTheClearHeightAlongTheAxis) {
  const MachineProfile profile = machine(Dialect::kRs274, false);
  std::istringstream in(
      "LOADTL/1,LENGTH,50\nSPINDL/500\nGOTO/0,0,1,0.6,0,0.8\nFEDRAT/100\nGOTO/5,0,0\nSTOP\nGOTO/"
      "10,0,0\nSPINDL/OFF\nFINI\n");
  const auto program = read_apt(in, "in.cls", {});
  ASSERT_TRUE(program) << program.error().message;
  PostOptions options;
  options.clear.height = 25.0;
  const auto text = program_text(*program, profile, options);
  ASSERT_TRUE(text) << text.error().message;
  const auto made = back(*text, profile);
  ASSERT_TRUE(made) << made.error().message;
  const std::vector<Move>& moves = made->operations[0].path.moves;
  const auto expect_at = [&](const Pose& pose, Point<Part> tip) {
    EXPECT_LT(distance(pose.tip, tip), 0.002) << pose.tip.x << " " << pose.tip.z;
    EXPECT_LT(angle_between(pose.axis, {0.6, 0, 0.8}), 1e-4);
  };
  // 24 mm higher along an axis that rises by 0.8; 25 mm from the last.
  expect_at(moves.front().pose, {18, 0, 25});
  expect_at(moves.back().pose, {10 + 18.75, 0, 25});
  EXPECT_EQ(moves.back().kind, MoveKind::kRapid);
  // The spindle turns before the tool comes down, the stop stands between the same places.
  const std::string& t = *text;
  EXPECT_LT(t.find("S500"), t.find("G0 X"));
  EXPECT_LT(t.find("M0"), t.find("M5"));
  // High enough: as the file says.
  options.clear.height = 1.0;
  const auto low = program_text(*program, profile, options);
  ASSERT_TRUE(low);
  EXPECT_LT(distance(back(*low, profile)->operations[0].path.moves.front().pose.tip, Point<Part>{0, 0, 1}),
            0.002);
}

/// A rapid that turns the tool over by exactly 180 degrees, far below the clear height: where the travels do
/// not let the tool rise so far, the refusal says how far they do, and that serves.
TEST(Post, AClearHeightBeyondTheTravelsIsRefusedWithOneThatServes) {
  std::size_t refusals = 0;
  for (const char* name : {"dmu-nutating-bc", "generic-ac", "vmc-bhead-bc", "linuxcnc-bridge-bc",
                           "linuxcnc-trunnion-ac", "linuxcnc-max5"}) {
    SCOPED_TRACE(name);
    const auto profile = load_machine(SOURCE_DIR "/config/machines/" + std::string(name) + ".yaml");
    ASSERT_TRUE(profile) << profile.error().message;
    std::istringstream in(
        "UNITS/MM\nMULTAX/ON\nLOADTL/1,LENGTH,100\nRAPID\nGOTO/0,0,-10,0.866025404,0,0.5\nFEDRAT/800,MMPM\n"
        "GOTO/0,0,-40,0.866025404,0,0.5\nRAPID\nGOTO/5,0,-10,0.866025404,0,0.5\nRAPID\n"
        "GOTO/5,0,-10,-0.866025404,0,0.5\nGOTO/5,0,-40,-0.866025404,0,0.5\nFINI\n");
    const auto program = read_apt(in, "in.cls", {});
    ASSERT_TRUE(program) << program.error().message;
    PostOptions options;
    options.setup.part_zero = {10, -5, 20};
    options.clear.height = 400.0;
    auto posted = post(*program, "in.cls", *profile, options);
    for (int i = 0; i < 2 && !posted; ++i) {  // once for each end
      ++refusals;
      const std::string& why = posted.error().message;
      const std::string words = "state --clear-height ";
      const std::size_t at = why.find(words);
      ASSERT_NE(at, why.npos) << why;
      EXPECT_TRUE(why.rfind("in.cls:5: the tool leans by 60 degrees", 0) == 0 ||
                  why.rfind("in.cls:12: the tool leans by 60 degrees", 0) == 0)
          << why;
      options.clear.height = std::strtod(why.c_str() + at + words.size(), nullptr);
      EXPECT_GT(*options.clear.height, -10.0);
      posted = post(*program, "in.cls", *profile, options);
    }
    EXPECT_TRUE(posted) << posted.error().message;
  }
  EXPECT_GE(refusals, 6u);
}

TEST(Post, ErrorsNameTheLineOfTheFile) {
  const MachineProfile profile = machine(Dialect::kFanuc, false);
  const struct {
    const char* text;
    const char* message;
  } table[]{{"LOADTL/1,LENGTH,50\nGOTO/0,0,10\nFEDRAT/100\n\nGOTO/0,0,0,0,0,-1\nFINI\n", "in.cls:5: move 1"},
            {"LOADTL/1,LENGTH,50\nGOTO/0,0,10\nFEDRAT/100\nGOTO/9000,0,0\nFINI\n", "in.cls:4: move 1"},
            {"LOADTL/1\nGOTO/0,0,10\nFINI\n", "in.cls: tool 1 has no length"}};
  for (const auto& row : table) {
    std::istringstream in(row.text);
    const auto program = read_apt(in, "in.cls", {});
    ASSERT_TRUE(program) << program.error().message;
    const auto text = program_text(*program, profile, {});
    ASSERT_FALSE(text) << row.text;
    EXPECT_EQ(text.error().message.rfind(row.message, 0), 0u) << text.error().message;
  }
}

/// Where no joints give a pose the first such line is named, with what the machine can do; clear space or
/// not.
TEST(Post, WhatNoJointsGiveIsNamedWithItsLine) {
  PostOptions options;
  options.clear = {60.0, 80.0};
  // A nutating head reaches so far only.
  std::istringstream in("LOADTL/1,LENGTH,50\nGOTO/0,0,10\nFEDRAT/100\nGOTO/0,0,0,0,0.6,-0.8\nFINI\n");
  const auto over = read_apt(in, "in.cls", {});
  ASSERT_TRUE(over) << over.error().message;
  const auto unreachable =
      program_text(*over, machine(Dialect::kHeidenhain, false, "dmu-nutating-bc"), options);
  ASSERT_FALSE(unreachable);
  EXPECT_EQ(unreachable.error().code, Code::kUnreachable);
  EXPECT_EQ(unreachable.error().message.rfind("in.cls:4: move ", 0), 0u) << unreachable.error().message;
  EXPECT_NE(unreachable.error().message.find("143.1"), std::string::npos) << unreachable.error().message;
  // A table with a gap, and a head to one side only: a quarter of the way round has no solution at all.
  MachineProfile gap = machine(Dialect::kRs274, false);
  gap.model.rotary.min = -130, gap.model.rotary.max = 130, gap.model.tilt.min = 0;
  const AptProgram round = winding(1.0);
  const auto stuck = program_text(round, gap, options);
  ASSERT_FALSE(stuck);
  EXPECT_EQ(stuck.error().code, Code::kLimit);
  EXPECT_EQ(stuck.error().message.rfind("in.cls:", 0), 0u) << stuck.error().message;
  EXPECT_NE(stuck.error().message.find(" C "), std::string::npos) << stuck.error().message;
  EXPECT_NE(stuck.error().message.find("turn the part on the table"), std::string::npos)
      << stuck.error().message;
  // A table of more than a turn, wound up: turned back it goes on.
  MachineProfile wound = machine(Dialect::kRs274, false);
  wound.model.rotary.min = -200, wound.model.rotary.max = 200;
  const auto end = program_text(winding(3.0), wound, {});
  ASSERT_FALSE(end);
  EXPECT_NE(end.error().message.find("so that the table unwinds"), std::string::npos) << end.error().message;
  // The line is the first whose pose neither solution gives.
  const auto line = static_cast<std::uint32_t>(std::stoul(stuck.error().message.substr(7)));
  const AptOperation& op = round.operations[0];
  std::size_t first = 0;
  const auto given = [&](const Pose& pose) {
    tiltfeed::Setup at;
    at.tool_length = 60.0;
    const auto solutions = inverse(gap.model, at, pose, 0.0);
    for (const Joints& q : *solutions)
      for (const double turn : {0.0, 360.0, -360.0})
        if (q.a >= 0.0 && q.c + turn >= -130.0 && q.c + turn <= 130.0) return true;
    return false;
  };
  while (given(op.path.moves[first].pose)) ++first;
  EXPECT_EQ(line, op.lines[first]);
}

}  // namespace
}  // namespace tiltfeed
