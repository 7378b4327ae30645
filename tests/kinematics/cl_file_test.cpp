// CL text: round trip, exact text, foreign files, one test per kind of bad input.

#include "kinematics/cl_text/cl_file.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <random>
#include <sstream>

#include "kinematics/cl_text/apt_file.h"

namespace tiltfeed {
namespace {

ToolPath random_path(std::size_t count, unsigned seed, double cut, double plunge) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  ToolPath path;
  path.name = "part 7.rev-b";
  path.tool = {6.35, 3.175, 123.456789};
  path.cut_feed = Feed::from_mm_per_min(cut);
  path.plunge_feed = Feed::from_mm_per_min(plunge);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 axis = normalized(Vec3{normal(random), normal(random), normal(random)});
    const auto kind = i == 0 ? MoveKind::kRapid : static_cast<MoveKind>(random() % 3);
    path.moves.push_back(
        {{{100 * normal(random), 100 * normal(random), 100 * normal(random)}, axis}, kind, kNoFacet});
  }
  return path;
}

Result<ToolPath> read_text(const std::string& text) {
  std::istringstream in(text);
  return read_cl(in, "part.cl");
}

std::string text_of(const ToolPath& path) {
  std::ostringstream out;
  write_cl(path, out);
  return out.str();
}

TEST(ClFile, StatesToolSpindleAndCoolantOfTheJob) {
  const ToolPath path = random_path(5, 5, 1200, 300);
  const struct {
    ClOperation set_up;
    const char* lines;
    std::size_t events;
  } table[]{{{}, "\nLOADTL/1,LENGTH,100\nPPRINT", 0},
            {{&path, 7, 0, 18000, 1}, "\nLOADTL/7,LENGTH,100\nSPINDL/18000,RPM,CLW\nCOOLNT/FLOOD\nPPRINT", 2},
            {{&path, 7, 14, -900.5, 2},
             "\nLOADTL/7,LENGTH,100,ADJUST,14\nSPINDL/900.5,RPM,CCLW\nCOOLNT/MIST\nPPRINT",
             2},
            {{&path, 0, 0, 0, 3}, "\nLOADTL/0,LENGTH,100\nCOOLNT/THRU\nPPRINT", 1}};
  for (const auto& row : table) {
    ToolPath tool = path;
    tool.tool.length = 100;
    std::ostringstream out;
    ClOperation operation = row.set_up;
    operation.path = &tool;
    write_cl({operation}, out);
    EXPECT_NE(out.str().find(row.lines), std::string::npos) << out.str();
    AptOptions options;
    options.unit_mm = 1.0, options.own_remarks = true;
    std::istringstream in(out.str());
    const auto back = read_apt(in, "part.cl", options);
    ASSERT_TRUE(back) << back.error().message;
    const AptOperation& op = back->operations.front();
    EXPECT_EQ(op.tool_number, row.set_up.tool);
    EXPECT_EQ(op.length_register, row.set_up.length_register);
    std::size_t events = 0;
    for (const PathEvent& event : op.events) {
      if (event.kind != EventKind::kSpindle && event.kind != EventKind::kCoolant) continue;
      const bool spindle = event.kind == EventKind::kSpindle;
      EXPECT_EQ(event.value, spindle ? row.set_up.spindle_rpm : row.set_up.coolant);
      ++events;
    }
    EXPECT_EQ(events, row.events);
    EXPECT_TRUE(read_text(out.str())) << "our own reader of paths takes them, too";
  }
}

TEST(ClFile, RoundTrip) {
  const struct { double cut, plunge; } table[]{{1200, 300}, {1.0 / 3, 0.1}, {500, 500}};  // equal feeds too
  for (const auto& feeds : table) {
    const ToolPath path = random_path(3000, 5, feeds.cut, feeds.plunge);
    const auto back = read_text(text_of(path));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->name, path.name);
    EXPECT_EQ(back->tool, path.tool);
    EXPECT_EQ(back->cut_feed, path.cut_feed);
    EXPECT_EQ(back->plunge_feed, path.plunge_feed);
    ASSERT_EQ(back->moves.size(), path.moves.size());
    for (std::size_t i = 0; i < path.moves.size(); ++i) {
      ASSERT_EQ(back->moves[i].kind, path.moves[i].kind) << "move " << i;
      ASSERT_LE(distance(back->moves[i].pose.tip, path.moves[i].pose.tip), 1e-6);
      ASSERT_LE(length(back->moves[i].pose.axis - path.moves[i].pose.axis), 2e-9);
      ASSERT_NEAR(length(back->moves[i].pose.axis), 1.0, 1e-15);
    }
  }
}

TEST(ClFile, Text) {
  ToolPath path;
  path.name = "pin";
  path.tool = {6, 3, 100};
  path.cut_feed = Feed::from_mm_per_min(800);
  path.plunge_feed = Feed::from_mm_per_min(200);
  path.moves = {{{{0, 0, 50}, {0, 0, 1}}, MoveKind::kRapid, 1},
                {{{1.5, -2, 10}, {0.6, 0, 0.8}}, MoveKind::kPlunge, 2},
                {{{2, -2, 9.1234567}, {0.6, 0, 0.8}}, MoveKind::kCut, 3},
                {{{3, -2, 9}, {0.6, 0, 0.8}}, MoveKind::kCut, 4},
                {{{3, -2, 50}, {0.6, 0, 0.8}}, MoveKind::kRapid, 5},
                {{{3, -2, 9}, {0.6, 0, 0.8}}, MoveKind::kCut, 6}};
  EXPECT_EQ(text_of(path),
            "PARTNO pin\nUNITS/MM\nMULTAX\nCUTTER/6,3\nLOADTL/1,LENGTH,100\n"
            "PPRINT TILTFEED FEEDS CUT,PLUNGE 800,200\n"
            "RAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/200,MMPM\nGOTO/1.5,-2,10,0.6,0,0.8\n"
            "FEDRAT/800,MMPM\nGOTO/2,-2,9.123457,0.6,0,0.8\nGOTO/3,-2,9,0.6,0,0.8\n"
            "RAPID\nGOTO/3,-2,50,0.6,0,0.8\nGOTO/3,-2,9,0.6,0,0.8\nFINI\n");
}

TEST(ClFile, ForeignFile) {
  const auto path = read_text(
      "$$ made elsewhere\r\nPARTNO  bracket $$ rev 2\r\n\r\nPPRINT hello\nCUTTER/10\nFEDRAT/900\n"
      "GOTO/0, 0, 50\nGOTO/ 1,2,3, 0,0.70711,0.70711\nGOTO/4,5,6\nFEDRAT/100,MMPM\nRAPID\nGOTO/7,8,9\n"
      "GOTO/7,8,8\nFINI\n");
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path->name, "bracket");
  EXPECT_EQ(path->tool.diameter, 10.0);
  EXPECT_EQ(path->cut_feed.mm_per_min(), 900.0);
  EXPECT_EQ(path->plunge_feed.mm_per_min(), 100.0);
  ASSERT_EQ(path->moves.size(), 5u);
  EXPECT_EQ(path->moves[0].kind, MoveKind::kRapid);
  EXPECT_EQ(path->moves[1].kind, MoveKind::kCut);
  EXPECT_EQ(path->moves[3].kind, MoveKind::kRapid);
  EXPECT_EQ(path->moves[4].kind, MoveKind::kPlunge);
  EXPECT_NEAR(path->moves[2].pose.axis.y, std::sqrt(0.5), 1e-15);
  EXPECT_EQ(path->moves[2].pose.axis, path->moves[4].pose.axis);
}

TEST(ClFile, BadInputIsNamedWithItsLine) {
  const struct {
    const char* text;
    const char* message;
  } table[]{
      {"", "part.cl:0: the file ends without FINI"},
      {"GOTO/0,0,0\n", "part.cl:1: the file ends without FINI"},
      {"PARTNO a\nFINI\n", "part.cl:2: no GOTO/"},
      {"GOTO/0,0\nFINI\n", "part.cl:1:1: GOTO/ has 2 numbers"},
      {"GOTO/0,0,0,1\nFINI\n", "part.cl:1:1: GOTO/ has 4 numbers"},
      {"GOTO/0,0,0,0,0,1,5\nFINI\n", "part.cl:1:1: GOTO/ has 7 numbers"},
      {"GOTO/0,0,0,0,0,1,\nFINI\n", "part.cl:1:17: GOTO/: number 7 is missing"},
      {"GOTO/0,0,nan\nFINI\n", "part.cl:1:10: GOTO/: number 3, \"NAN\", is no number"},
      {"GOTO/0,0,1e999\nFINI\n", "part.cl:1:10: GOTO/: number 3, \"1E999\", is no number"},
      {"GOTO/0;0;0\nFINI\n", "part.cl:1:6: GOTO/: number 1, \"0;0;0\", is no number"},
      {"\nGOTO/0,0,0,0,0,2\nFINI\n", "part.cl:2:12: the tool axis (0, 0, 2) is not of length 1"},
      {"FEDRAT/0\nFINI\n", "part.cl:1:1: FEDRAT/ wants"},
      {"GOTO/0,0,0\nFEDRAT/5\nGOTO/0,0,1\nFEDRAT/6\nGOTO/0,0,2\nFEDRAT/7\nGOTO/0,0,3\nFINI\n",
       "part.cl:7: a third feed, 7 mm/min"},
      {"PPRINT TILTFEED FEEDS CUT,PLUNGE 8,2\nGOTO/0,0,0\nFEDRAT/9\nGOTO/0,0,1\nFINI\n",
       "part.cl:4: a third feed, 9 mm/min"},
      {"PPRINT TILTFEED FEEDS CUT,PLUNGE 8\nGOTO/0,0,0\nFINI\n", "part.cl:2: the feeds remark wants"},
      {"PPRINT TILTFEED FEEDS CUT,PLUNGE 8,nan\nGOTO/0,0,0\nFINI\n", "part.cl:2: the feeds remark wants"},
      {"CUTTER/-1\n", "part.cl:1:1: CUTTER/ wants"},
      {"LOADTL/x,LENGTH,-1\n", "part.cl:1:1: LOADTL/ wants"},
      {"LOADTL/1\nGOTO/0,0,0\nLOADTL/2\nGOTO/0,0,1\nFINI\n", "part.cl:4: a second tool"},
      {"GOTO/0,0,0\nUNITS/INCHES\nFINI\n", "part.cl:2:1: UNITS/ stands behind the first motion"},
      {"WOBBLE\nGOTO/0,0,0\nFINI\n", "part.cl:1: WOBBLE is not understood"},
      {"CIRCLE/1,2,3\n", "part.cl:1:1: CIRCLE/ has 3 numbers"}};
  for (const auto& row : table) {
    const auto path = read_text(row.text);
    ASSERT_FALSE(path) << row.text;
    EXPECT_EQ(path.error().code, Code::kInput);
    EXPECT_EQ(path.error().message.rfind(row.message, 0), 0u) << path.error().message;
  }
}

TEST(ClFile, EveryTruncationIsAnError) {
  const std::string text = text_of(random_path(20, 9, 100, 50));
  for (std::size_t size = 0; size + 1 < text.size(); ++size)
    EXPECT_FALSE(read_text(text.substr(0, size))) << size;
  EXPECT_TRUE(read_text(text.substr(0, text.size() - 1)));
}

/// Also the measure of speed, printed and not judged.
TEST(ClFile, AMillionMoves) {
  const ToolPath path = random_path(1'000'000, 3, 1200, 300);
  const auto start = std::chrono::steady_clock::now();
  std::stringstream text;
  write_cl(path, text);
  const auto written = std::chrono::steady_clock::now();
  const auto back = read_cl(text, "part.cl");
  const auto read = std::chrono::steady_clock::now();
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->moves.size(), path.moves.size());
  EXPECT_LE(distance(back->moves.back().pose.tip, path.moves.back().pose.tip), 1e-6);
  std::printf("written in %.2f s, read in %.2f s\n", std::chrono::duration<double>(written - start).count(),
              std::chrono::duration<double>(read - written).count());
}

}  // namespace
}  // namespace tiltfeed
