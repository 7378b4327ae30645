// APT text of other CAM systems: every word that is understood, every kind of bad input with its line, there
// and back.

#include "kinematics/cl_text/apt_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

namespace tiltfeed {
namespace {

Result<AptProgram> read_apt_text(const std::string& text, const AptOptions& options = {}) {
  std::istringstream in(text);
  return read_apt(in, "p.cls", options);
}

TEST(AptFile, AForeignFile) {
  const auto program = read_apt_text(
      "$$ made elsewhere\r\nPARTNO  bracket $$ rev 2\r\n\r\nmultax/on\nUNITS / MM\nCUTTER/10, 2\n"
      "LOADTL/ 7 ,ADJUST,2,LENGTH, 120.5\nSPINDL/RPM,8000,CCLW\nCOOLNT/MIST\nPPRINT wall, left\nFROM/1,1,1\n"
      "GOTO/0, 0, 50\nFEDRAT/ 900 ,MMPM\nGOTO/ 1,2,3, $\n 0, $\n "
      "0.2,0.2\nGODLTA/0,0,1\nGODLTA/2\nFEDRAT/MMPM,100\n"
      "RAPID\nGOTO/7,8,+9.E0\nDELAY/1.5\nGOTO/7,8,8\nSTOP\nOPSTOP\nCOOLNT/OFF\nSPINDL/OFF\nFINI\nPPRINT "
      "not read\n");
  ASSERT_TRUE(program) << program.error().message;
  EXPECT_EQ(program->name, "bracket");
  EXPECT_TRUE(program->notes.empty());
  ASSERT_EQ(program->operations.size(), 1u);
  const AptOperation& op = program->operations[0];
  EXPECT_EQ(op.tool_number, 7);
  EXPECT_EQ(op.path.tool, (ToolData{10, 2, 120.5}));
  ASSERT_EQ(op.path.moves.size(), 6u);
  EXPECT_EQ(op.lines, (std::vector<std::uint32_t>{12, 14, 17, 18, 21, 23}));
  const std::vector<MoveKind> kinds{MoveKind::kRapid, MoveKind::kCut,   MoveKind::kCut,
                                    MoveKind::kCut,   MoveKind::kRapid, MoveKind::kCut};
  for (std::size_t i = 0; i < kinds.size(); ++i) EXPECT_EQ(op.path.moves[i].kind, kinds[i]) << i;
  EXPECT_EQ(op.path.moves[2].pose.tip, (Point<Part>{1, 2, 4}));
  EXPECT_NEAR(op.path.moves[3].pose.tip.y, 2 + 2 * std::sqrt(0.5), 1e-12) << "along the tool axis";
  EXPECT_NEAR(op.path.moves[1].pose.axis.y, std::sqrt(0.5), 1e-15);
  EXPECT_EQ(op.path.moves[4].pose.tip, (Point<Part>{7, 8, 9}));
  EXPECT_EQ(feed_of(op.path, 1).mm_per_min(), 900.0);
  EXPECT_EQ(feed_of(op.path, 3).mm_per_min(), 900.0);
  EXPECT_EQ(feed_of(op.path, 5).mm_per_min(), 100.0);
  const std::vector<PathEvent> events{{0, EventKind::kSpindle, -8000, ""},
                                      {0, EventKind::kCoolant, 2, ""},
                                      {0, EventKind::kRemark, 0, "wall, left"},
                                      {5, EventKind::kDwell, 1.5, ""},
                                      {6, EventKind::kStop, 0, ""},
                                      {6, EventKind::kOptionalStop, 0, ""},
                                      {6, EventKind::kCoolant, 0, ""},
                                      {6, EventKind::kSpindle, 0, ""}};
  EXPECT_EQ(op.events, events);
}

TEST(AptFile, AByteOrderMarkHidesNoUnit) {
  const auto program = read_apt_text("\xEF\xBB\xBFUNITS/INCHES\nLOADTL/1,LENGTH,4\nGOTO/1,0,2\nFINI\n");
  ASSERT_TRUE(program) << program.error().message;
  EXPECT_TRUE(program->notes.empty());
  EXPECT_EQ(program->operations[0].path.moves[0].pose.tip, (Point<Part>{25.4, 0, 50.8}));
}

TEST(AptFile, InchesAndFeedsPerTurn) {
  const auto program = read_apt_text(
      "UNITS/INCHES\nCUTTER/0.5\nLOADTL/1,LENGTH,4\nSPINDL/1000\nGOTO/1,0,2\nFEDRAT/10\nGOTO/1,0,1\n"
      "FEDRAT/10,IPM\nGOTO/1,0,0.5\nFEDRAT/300,MMPM\nGOTO/1,0,0.25\nFEDRAT/0.01,IPR\nGOTO/1,0,0\n"
      "FEDRAT/0.1,MMPR\nGOTO/2,0,0\nEND\n");
  ASSERT_TRUE(program) << program.error().message;
  const ToolPath& path = program->operations[0].path;
  EXPECT_EQ(path.tool, (ToolData{12.7, 0, 101.6}));
  EXPECT_EQ(path.moves[0].pose.tip, (Point<Part>{25.4, 0, 50.8}));
  const double feeds[]{0, 254, 254, 300, 254, 100};
  for (std::size_t i = 1; i < 6; ++i) EXPECT_NEAR(feed_of(path, i).mm_per_min(), feeds[i], 1e-9) << i;
  const auto stated = read_apt_text("LOADTL/1,LENGTH,4\nGOTO/1,0,2\nFINI\n", {25.4, 0.0});
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->operations[0].path.tool.length, 101.6) << "the unit of a file without UNITS/";
}

TEST(AptFile, AUnitThatNothingStatesIsNoted) {
  const std::string text = "GOTO/0,0,1\nFEDRAT/5\nGOTO/0,0,0\nFINI\n";
  const auto silent = read_apt_text(text);
  ASSERT_TRUE(silent) << silent.error().message;
  ASSERT_EQ(silent->notes.size(), 1u);
  EXPECT_EQ(silent->notes[0], "p.cls: no UNITS/: its numbers are taken as mm (else: --units inch)");
  EXPECT_TRUE(read_apt_text("UNITS/MM\n" + text)->notes.empty());
  const auto inch = read_apt_text(text, {25.4, 0.0});
  EXPECT_TRUE(inch->notes.empty());
  EXPECT_EQ(inch->operations[0].path.moves[0].pose.tip.z, 25.4);
  EXPECT_EQ(feed_of(inch->operations[0].path, 1).mm_per_min(), 127.0);
}

TEST(AptFile, EachToolIsAnOperation) {
  const auto program = read_apt_text(
      "CUTTER/6\nLOADTL/1,LENGTH,90\nFEDRAT/100\nGOTO/0,0,9\nGOTO/0,0,0\nCUTTER/8,4\nLOAD/TOOL,2\nGOTO/"
      "5,5,9\n"
      "GOTO/5,5,0\nLOADTL/3\nFINI\n",
      {1.0, 70.0});
  ASSERT_TRUE(program) << program.error().message;
  ASSERT_EQ(program->operations.size(), 2u);
  EXPECT_EQ(program->operations[0].path.tool, (ToolData{6, 0, 90}));
  EXPECT_EQ(program->operations[1].path.tool, (ToolData{8, 4, 70})) << "the length of the command line";
  EXPECT_EQ(program->operations[1].tool_number, 2);
  EXPECT_EQ(program->operations[1].path.moves[0].kind, MoveKind::kRapid);
  EXPECT_EQ(feed_of(program->operations[1].path, 1).mm_per_min(), 100.0) << "the feed stays";
}

TEST(AptFile, SeveralPathsInOneFile) {
  const std::string path =
      "TOOL PATH/FINISH,TOOL,BALL_6\nTLDATA/MILL,6.0000,3.0000,75.0000,0.0000,0.0000\n"
      "MSYS/0,0,0,1,0,0,0,1,0\nLOAD/TOOL,3\nSPINDL/RPM,8000,CLW\nPAINT/SPEED,10\nRAPID\n"
      "GOTO/1.5E+01,-2.5e0,5.0D+01,0.0,0.0,1.0\nFEDRAT/MMPM,250.0\nGOTO/15.0,-2.5,-5.0D-1\nEND-OF-PATH\n";
  std::istringstream in(path + path);
  const auto program = read_apt(in, "nx.cls", {1.0, 75.0});
  ASSERT_TRUE(program) << program.error().message;
  EXPECT_TRUE(program->notes.empty()) << program->notes.front();
  ASSERT_EQ(program->operations.size(), 2u);
  for (const AptOperation& op : program->operations) {
    EXPECT_EQ(op.tool_number, 3);
    EXPECT_EQ(op.path.tool, (ToolData{6.0, 3.0, 75.0}));
    ASSERT_EQ(op.path.moves.size(), 2u);
    EXPECT_EQ(op.path.moves[0].pose.tip, (Point<Part>{15.0, -2.5, 50.0}));
    EXPECT_EQ(op.path.moves[1].pose.tip, (Point<Part>{15.0, -2.5, -0.5}));
    EXPECT_EQ(feed_of(op.path, 1).mm_per_min(), 250.0);
  }
  // A path that is not closed is cut short.
  std::istringstream open(path + path.substr(0, path.find("END-OF-PATH")));
  const auto refused = read_apt(open, "nx.cls", {1.0, 75.0});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("cut short"), std::string::npos);
}

TEST(AptFile, UnknownWordsAreNotedAndNotFatal) {
  const auto program =
      read_apt_text("UNITS/MM\nMAGIC/1\nGOTO/0,0,0\nMAGIC/2\nMACHIN/MILL\nCOOLNT/AIR\nCYCLE/OFF\nFINI\n");
  ASSERT_TRUE(program) << program.error().message;
  EXPECT_EQ(program->notes,
            (std::vector<std::string>{"p.cls:2: MAGIC is not understood and was left out (2 times)",
                                      "p.cls:6: COOLNT/AIR is posted as flood"}));
}

TEST(AptFile, BadInputIsNamedWithItsLine) {
  const struct {
    const char* text;
    const char* message;
  } table[]{
      {"", "p.cls:0: the file ends without FINI"},
      {"GOTO/0,0,0\n", "p.cls:1: the file ends without FINI"},
      {"PARTNO a\nFINI\n", "p.cls:2: no GOTO/"},
      {"\nGOTO/0,0\nFINI\n", "p.cls:2:1: GOTO/ has 2 numbers"},
      {"GOTO/0,,0,0,0,1\nFINI\n", "p.cls:1:7: GOTO/: number 2 is missing"},
      {"GOTO/0,0,0,0,0,1,\nFINI\n", "p.cls:1:17: GOTO/: number 7 is missing"},
      {"GOTO/0,0, $\n nan\nFINI\n", "p.cls:2:2: GOTO/: number 3, \"NAN\", is no number"},
      {"GOTO/0,0,1e999\nFINI\n", "p.cls:1:10: GOTO/: number 3, \"1E999\", is no number"},
      {"GOTO/0,0,****\nFINI\n", "p.cls:1:10: GOTO/: number 3, \"****\", is no number"},
      {"GOTO/0,0,0,0,0,0\nFINI\n", "p.cls:1:12: the tool axis (0, 0, 0) has no length"},
      {"GOTO/0,0,0\nGOTO/0,0,1\nFINI\n", "p.cls:2:1: no FEDRAT/ yet"},
      {"GOTO/0,0,0\nFEDRAT/5,IPM\nGOTO/0,0,1\nFINI\n",
       "p.cls:2:1: the feed is in inches and nothing states the unit"},
      {"FEDRAT/0\nFINI\n", "p.cls:1:1: FEDRAT/ wants a feed above 0"},
      {"FEDRAT/nan\nFINI\n", "p.cls:1:1: FEDRAT/ wants a feed above 0"},
      {"FEDRAT/MMPM\nFINI\n", "p.cls:1:1: FEDRAT/ has no number"},
      {"GOTO/0,0,0\nFEDRAT/0.1,MMPR\nGOTO/0,0,1\n", "p.cls:3:1: the feed per turn needs a spindle speed"},
      {"SPINDL/-5\n", "p.cls:1:1: SPINDL/ wants"},
      {"SPINDL/SFM,300\n", "p.cls:1:1: SPINDL/ is understood in RPM"},
      {"CUTTER/-1\n", "p.cls:1:1: CUTTER/ wants"},
      {"LOADTL/1.5\n", "p.cls:1:1: LOADTL/ wants a tool number"},
      {"LOADTL/1,LENGTH,x\n", "p.cls:1:1: LOADTL/ wants a LENGTH"},
      {"UNITS/FEET\n", "p.cls:1:1: UNITS/ wants"},
      {"DELAY/-1\n", "p.cls:1:1: DELAY/ wants"},
      {"GODLTA/1,2\n", "p.cls:1:1: GODLTA/ wants"},
      {"TLAXIS/0,0\n", "p.cls:1:1: TLAXIS/ wants"},
      {"ROTABL/90\n", "p.cls:1:1: ROTABL/ asks for more than the points"}};
  for (const auto& row : table) {
    const auto program = read_apt_text(row.text);
    ASSERT_FALSE(program) << row.text;
    EXPECT_EQ(program.error().code, Code::kInput);
    EXPECT_EQ(program.error().message.rfind(row.message, 0), 0u) << program.error().message;
  }
}

TEST(AptFile, RoundTrip) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  AptProgram program;
  program.name = "part 7";
  for (int k = 1; k <= 3; ++k) {
    AptOperation op;
    op.tool_number = k;
    op.length_register = 10 * (k - 1);
    op.path.name = program.name;
    op.path.tool = {6.0 + k, 1, 100.5};
    for (std::size_t i = 0; i < 2000; ++i) {
      const Vec3 axis = normalized(Vec3{normal(random), normal(random), normal(random)});
      const auto kind = i == 0 || random() % 5 == 0 ? MoveKind::kRapid : MoveKind::kCut;
      op.path.moves.push_back(
          {{{9 * normal(random), 9 * normal(random), 9 * normal(random)}, axis}, kind, kNoFacet});
      if (i > 0 && (i == 1 || random() % 9 == 0))
        op.path.feeds.push_back({static_cast<std::uint32_t>(i),
                                 Feed::from_mm_per_min(100.0 + static_cast<double>(random() % 900))});
      if (random() % 50 == 0)
        op.events.push_back({i, EventKind::kSpindle, static_cast<double>(random() % 9000) - 4000.0, ""});
      if (i % 500 == 100) op.events.push_back({i, EventKind::kCutterLeft, 0.0, ""});
      if (i % 500 == 150) op.events.push_back({i, EventKind::kCutterOff, 0.0, ""});
      if (i % 500 == 200) op.events.push_back({i, EventKind::kCutterRight, 12.0, ""});
      if (i % 500 == 300) op.events.push_back({i, EventKind::kCutterOff, 0.0, ""});
      if (random() % 50 == 0)
        op.events.push_back({i, EventKind::kCoolant, static_cast<double>(random() % 3), ""});
    }
    program.operations.push_back(op);
  }
  std::stringstream text;
  write_apt(program, text);
  const auto back = read_apt(text, "p.cls", {});
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->operations.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const AptOperation &want = program.operations[k], &got = back->operations[k];
    EXPECT_EQ(got.tool_number, want.tool_number);
    EXPECT_EQ(got.length_register, want.length_register);
    EXPECT_EQ(got.path.tool, want.path.tool);
    EXPECT_EQ(got.events, want.events);
    ASSERT_EQ(got.path.moves.size(), want.path.moves.size());
    for (std::size_t i = 0; i < want.path.moves.size(); ++i) {
      ASSERT_EQ(got.path.moves[i].kind, want.path.moves[i].kind) << i;
      ASSERT_LE(distance(got.path.moves[i].pose.tip, want.path.moves[i].pose.tip), 1e-6);
      ASSERT_LE(length(got.path.moves[i].pose.axis - want.path.moves[i].pose.axis), 2e-9);
      if (want.path.moves[i].kind == MoveKind::kRapid) continue;
      ASSERT_EQ(feed_of(got.path, i), feed_of(want.path, i)) << i;
    }
  }
}

}  // namespace
}  // namespace tiltfeed
