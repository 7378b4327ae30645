// Holes, arcs and cutter compensation of CL files in programs: the tool path that a program makes is that of
// the text, which a second reader reads.

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/judges/apt_judge.h"
#include "tests/judges/dialect_reader.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

constexpr double kTip = 0.005 + 0.002;  // the post's tolerance, and words of three decimals
constexpr double kAxis = 0.06;          // degrees

// As CAMWorks writes: set-ups on three sides, drilling, compensation, arcs.
constexpr const char* kWork =
    "PARTNO/1\nUNIT/MM\nINSERT/[HOLDER=C40] 6MM DRILL\nCUTTER/6.,0,3.,1.8,31.,0,45.\nLOAD/TOOL,6\n"
    "CSI_SET_FLUTE_LENGTH/2.\nSELECT/TOOL,15\nCOOLNT/FLOOD\nSPINDL/3141,RPM,CLW\nTRNTYP/WORLD,0,0,0\n"
    "CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\nRAPID/\nGOTO/0,75.,25.\nCYCLE/INIT\n"
    "CYCLE/DRILL,FEDTO,2.5,MMPM,207.5,RAPTO,3.,RTRCTO,25.1,DWELL,0\nGOTO/0,75.,-0.1\nGOTO/60.92,64.13,-0.1\n"
    "CYCLE/OFF\nCUTTER/4.,0,2.\nLOAD/TOOL,7\nSPINDL/4000,RPM,CLW\nCSYS/0,0,-1.,0,-1.,0,0,0,0,1.,0,0\nRAPID/\n"
    "GOTO/-25.,30.,-20.,-1.,0,0\nCYCLE/INIT\n"
    "CYCLE/DEEP2,FEDTO,12.,1STPECK,5.,SUBPECK,2.,MMPM,150.,RAPTO,3.,RTRCTO,25.\nGOTO/0,30.,-20.,-1.,0,0\n"
    "GOTO/0,40.,-20.,-1.,0,0\nCYCLE/OFF\nRAPID/\nGOTO/-40.,40.,-20.,-1.,0,0\nRAPID/\nGOTO/"
    "-40.,40.,60.,0,0,1.\n"
    "CUTTER/14.,0,7.\nLOAD/TOOL,16\nSPINDL/1677,RPM,CLW\nCSYS/1.,0,0,0,0,1.,0,33.,0,0,1.,0\nRAPID/\n"
    "GOTO/20.597218,-6.692519,25.\nRAPID/\nGOTO/20.597218,-6.692519,3.\nFEDRAT/263.6,MMPM\n"
    "GOTO/20.597218,-6.692519,-5.\nCUTCOM/LEFT\nFEDRAT/790.9,MMPM\nGOTO/16.721765,-3.225407,-5.\n"
    "CIRCLE/16.055013,-3.970687,-5.,0,0,1.\nGOTO/15.999486,-2.972229,-5.\nFEDRAT/1054.6,MMPM\n"
    "CIRCLE/15.,15.,-5.,0,0,-1.\nGOTO/15.,-3.,-5.\nCIRCLE/15.,15.,-5.,0,0,-1.\nGOTO/15.,-3.,-5.\nCUTCOM/OFF\n"
    "GOTO/9.402782,-6.692519,-5.\nRAPID/\nGOTO/9.402782,-6.692519,3.\nFINI\n";

PostOptions on_table() {
  PostOptions options;
  options.setup.part_zero = {10, -20, 30};
  return options;
}

AptProgram read(const std::string& text, const std::vector<std::string>& ignored = {}) {
  std::istringstream in(text);
  const auto program = read_apt(in, "in.cls", {0.0, 120.0, 0.0, 0.0025, ignored});
  EXPECT_TRUE(program) << program.error().message;
  return program.value_or(AptProgram{});
}

class Cycles : public testing::TestWithParam<DialectCase> {};
INSTANTIATE_TEST_SUITE_P(All, Cycles, testing::ValuesIn(dialect_cases()), case_name);

TEST_P(Cycles, TheProgramIsTheText) {
  const MachineProfile profile = profile_of(GetParam());
  auto text = program_text(read(kWork), profile, on_table());
  const bool shifts = GetParam().dialect != Dialect::kGrbl && !GetParam().tcp;
  ASSERT_EQ(text.has_value(), shifts);
  if (!shifts) {
    EXPECT_NE(text.error().message.find("in.cls:46: CUTCOM/: "), std::string::npos) << text.error().message;
    EXPECT_NE(text.error().message.find("say --ignore CUTCOM"), std::string::npos);
    text = program_text(read(kWork, {"CUTCOM"}), profile, on_table());
    ASSERT_TRUE(text) << text.error().message;
  }
  const auto made = back(*text, profile);
  ASSERT_TRUE(made) << made.error().message;
  std::istringstream in(kWork);
  WayOfProgram(*made, kTip, kAxis).expect(AptJudge(in).corners());
  std::vector<EventKind> sides;
  for (const PathEvent& event : made->operations.back().events)
    if (event.kind >= EventKind::kCutterLeft) sides.push_back(event.kind);
  const std::vector<EventKind> want{EventKind::kCutterLeft, EventKind::kCutterOff};
  EXPECT_EQ(sides, shifts ? want : std::vector<EventKind>{});
}

TEST(PostWords, TheLengthsRegisterIsTheFiles) {
  const std::string text =
      "UNITS/MM\nLOADTL/7,ADJUST,9\nSPINDL/1000\nRAPID\nGOTO/0,0,10\nFEDRAT/100,MMPM\nGOTO/1,0,0\nFINI\n";
  const struct {
    Dialect dialect;
    bool tcp;
    const char* word;
  } table[]{{Dialect::kRs274, false, "\nG43 H9\n"},
            {Dialect::kFanuc, false, " G43 H9 "},
            {Dialect::kFanuc, true, " G43.4 H9 "},
            {Dialect::kHaas, true, " G234 H9 "},
            {Dialect::kSiemens, false, "\nD9\n"}};
  for (const auto& row : table) {
    const MachineProfile profile = profile_of({row.dialect, row.tcp});
    const auto program = program_text(read(text), profile, on_table());
    ASSERT_TRUE(program) << program.error().message;
    EXPECT_NE(program->find(row.word), std::string::npos) << *program;
    const auto made = back(*program, profile);
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->operations[0].length_register, 9);
    std::string unstated = text;
    unstated.erase(unstated.find(",ADJUST,9"), 9);
    const auto plain = program_text(read(unstated), profile, on_table());
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->find("H9"), std::string::npos);
    EXPECT_EQ(back(*plain, profile)->operations[0].length_register, 0);
  }
}

TEST(PostWords, CompensationWorksInThePlaneOfXAndY) {
  const auto side = [](const std::string& axis, const std::string& end, const std::string& register_word) {
    return "UNITS/MM\nLOADTL/3\nRAPID\nGOTO/0,0,10," + axis + "\nFEDRAT/100,MMPM\nCUTCOM/RIGHT" +
           register_word + "\nGOTO/1,0,0," + axis + "\nGOTO/9,0,0," + end + "\nCUTCOM/OFF\nFINI\n";
  };
  const MachineProfile head = profile_of({Dialect::kFanuc, false});
  const auto error_of = [&](const std::string& text, const MachineProfile& machine) {
    const auto program = program_text(read(text), machine, on_table());
    return program ? "" : program.error().message;
  };
  EXPECT_NE(
      error_of(side("0.6,0,0.8", "0.6,0,0.8", ""), head).find("the tool is along no axis of the machine"),
      std::string::npos);
  EXPECT_NE(error_of(side("0,0,1", "0.1,0,0.995", ""), head).find("in.cls:7: CUTCOM/: a rotary turns"),
            std::string::npos);
  // On a trunnion the tool is along Z always.
  MachineProfile trunnion = machine(Dialect::kFanuc, false, "linuxcnc-trunnion-ac");
  const auto text = program_text(read(side("0.6,0,0.8", "0.6,0,0.8", ",12")), trunnion, on_table());
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_NE(text->find("\nG42 D12\n"), std::string::npos);
  const auto made = back(*text, trunnion);
  ASSERT_TRUE(made);
  const std::vector<PathEvent>& events = made->operations[0].events;
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0], (PathEvent{1, EventKind::kCutterRight, 12.0, ""}));
  EXPECT_EQ(events[1].kind, EventKind::kCutterOff);
}

/// A Heidenhain control takes RL, RR and R0 (G41, G42 and G40 in DIN/ISO) in a block that moves the tool in
/// the plane, and keeps the one in force where a block has none.
TEST(PostWords, AHeidenhainTakesTheSideInABlockThatMovesInThePlane) {
  const std::string text =
      "UNITS/MM\nLOADTL/3\nRAPID\nGOTO/0,0,10\nFEDRAT/100,MMPM\nCUTCOM/RIGHT\nGOTO/0,0,0\nGOTO/5,0,0\n"
      "GOTO/9,3,0\nCUTCOM/OFF\nRAPID\nGOTO/9,3,4\nGOTO/20,3,4\nCUTCOM/LEFT,3\nGOTO/20,8,4\nGOTO/25,8,4\n"
      "CUTCOM/OFF\nGOTO/30,8,4\nFINI\n";
  const std::vector<std::string> dialogue{"L Z+0 F100", "L X+5 RR", "L X+9 Y+3", "L Z+4 FMAX",
                                          "L X+20 R0",  "L Y+8 RL", "L X+25",    "L X+30 R0"},
      iso{"G01 Z+0 F100", "G42 X+5", "X+9 Y+3", "G00 Z+4", "G01 G40 X+20", "G41 Y+8", "X+25", "G40 X+30"};
  for (const Dialect dialect : {Dialect::kHeidenhain, Dialect::kHeidenhainIso}) {
    const MachineProfile profile = profile_of({dialect, false});
    const auto program = program_text(read(text), profile, on_table());
    ASSERT_TRUE(program) << program.error().message;
    std::size_t at = 0;
    for (const std::string& want : dialect == Dialect::kHeidenhain ? dialogue : iso) {
      at = program->find(" " + want + (dialect == Dialect::kHeidenhain ? "\n" : "*\n"), at);
      ASSERT_NE(at, program->npos) << want << "\n" << *program;
    }
    const auto made = back(*program, profile);
    ASSERT_TRUE(made) << made.error().message;
    std::vector<std::pair<EventKind, double>> sides;  // and the X of the first point behind
    for (const PathEvent& event : made->operations[0].events)
      if (event.kind >= EventKind::kCutterLeft && event.kind <= EventKind::kCutterOff)
        sides.emplace_back(event.kind, made->operations[0].path.moves[event.move].pose.tip.x);
    ASSERT_EQ(sides.size(), 4u) << *program;
    const std::vector<std::pair<EventKind, double>> want{{EventKind::kCutterRight, 5},
                                                         {EventKind::kCutterOff, 20},
                                                         {EventKind::kCutterLeft, 20},
                                                         {EventKind::kCutterOff, 30}};
    for (std::size_t i = 0; i < want.size(); ++i) {
      EXPECT_EQ(sides[i].first, want[i].first);
      EXPECT_NEAR(sides[i].second, want[i].second, 1e-3);
    }
  }
}

/// Where the control cannot be told a register, another than the one that is called is refused, not dropped.
TEST(PostWords, ARegisterThatCannotBeToldIsRefused) {
  const auto text = [](const std::string& load, const std::string& side) {
    return "UNITS/MM\nLOADTL/3" + load + "\nRAPID\nGOTO/0,0,10\nFEDRAT/100,MMPM\nCUTCOM/LEFT" + side +
           "\nGOTO/5,0,10\nCUTCOM/OFF\nGOTO/9,3,10\nFINI\n";
  };
  const auto error_of = [&](Dialect dialect, const std::string& load, const std::string& side,
                            const std::vector<std::string>& ignored = {}) {
    const auto program =
        program_text(read(text(load, side), ignored), profile_of({dialect, false}), on_table());
    return program ? "" : program.error().message;
  };
  for (const Dialect dialect : {Dialect::kSiemens, Dialect::kHeidenhain, Dialect::kHeidenhainIso}) {
    EXPECT_EQ(error_of(dialect, "", ""), "");
    EXPECT_EQ(error_of(dialect, "", ",3"), "");
    EXPECT_NE(error_of(dialect, "", ",5").find("in.cls:7: CUTCOM/: register 5"), std::string::npos)
        << error_of(dialect, "", ",5");
  }
  EXPECT_EQ(error_of(Dialect::kSiemens, ",ADJUST,5", ",5"), "");
  EXPECT_NE(error_of(Dialect::kSiemens, ",ADJUST,5", ",3"), "");
  EXPECT_EQ(error_of(Dialect::kFanuc, ",ADJUST,5", ",7"), "");
  for (const Dialect dialect : {Dialect::kHeidenhain, Dialect::kHeidenhainIso}) {
    EXPECT_EQ(error_of(dialect, ",ADJUST,3", ""), "");
    EXPECT_NE(error_of(dialect, ",ADJUST,9", "").find("say --ignore ADJUST"), std::string::npos);
    EXPECT_EQ(error_of(dialect, ",ADJUST,9", "", {"ADJUST"}), "");
  }
}

TEST(PostWords, AHeidenhainNeedsTheEndOfCompensation) {
  const std::string text =
      "UNITS/MM\nLOADTL/3\nRAPID\nGOTO/0,0,10\nFEDRAT/100,MMPM\nCUTCOM/LEFT\nGOTO/5,0,10\nFINI\n";
  const auto program = program_text(read(text), profile_of({Dialect::kHeidenhain, false}), on_table());
  ASSERT_FALSE(program);
  EXPECT_NE(program.error().message.find("no CUTCOM/OFF ends it"), std::string::npos)
      << program.error().message;
}

/// Where the way goes when the control shifts it by 1 mm: of the plane's third axis and the way the cross
/// product is left, as seen from that axis's tip.
Vec3 shifted(int plane, bool left, Vec3 way) {
  const Vec3 third = plane == 17 ? Vec3{0, 0, 1} : (plane == 18 ? Vec3{0, 1, 0} : Vec3{1, 0, 0});
  return normalized(cross(third, way)) * (left ? 1.0 : -1.0);
}

/// The side on which the part's tool path is shifted by a program with one stretch of compensation: above 0
/// left, as the operator sees it who looks along the tool. From the words alone, by the machine's way
/// forward.
double side_of(const std::string& program, const MachineProfile& profile, const AptOperation& op) {
  const SeenProgram seen =
      seen_program(program, false, profile.model.tilt.letter, profile.model.rotary.letter);
  int plane = 17;
  bool left = false, on = false;
  for (const std::string& line : seen.lines) {
    for (const int one : {17, 18, 19})
      if (!on && line == "G" + std::to_string(one)) plane = one;
    if (line.starts_with("G41") || line.starts_with("G42")) left = line[2] == '1', on = true;
  }
  EXPECT_TRUE(on) << program;
  const Setup setup{on_table().setup.part_zero, Rotation{}, op.path.tool.length};
  const std::size_t count = seen.blocks.size();
  const Joints from = seen.blocks[count - 2].words, to = seen.blocks[count - 1].words;
  const Vec3 by = shifted(plane, left, {to.x - from.x, to.y - from.y, to.z - from.z});
  Joints beside = to;
  beside.x += by.x, beside.y += by.y, beside.z += by.z;
  const Pose a = forward(profile.model, setup, from), b = forward(profile.model, setup, to),
             c = forward(profile.model, setup, beside);
  EXPECT_NEAR(distance(b.tip, c.tip), 1.0, 1e-9);
  return dot(c.tip - b.tip, normalized(cross(b.axis, b.tip - a.tip)));
}

TEST(PostWords, CompensationWorksInThePlaneThatTheToolIsSquareTo) {
  int planes = 0;
  for (const Dialect dialect : {Dialect::kFanuc, Dialect::kRs274, Dialect::kHaas, Dialect::kSiemens})
    for (const bool own : {true, false})
      for (const char* axis : {"0,0,1", "1,0,0", "-1,0,0", "0,1,0", "0,-1,0"})
        for (const std::string side : {"LEFT", "RIGHT"}) {
          SCOPED_TRACE(std::string(axis) + " " + side + (own ? " head B " : " head A ") +
                       name_of(dialect).name);
          const MachineProfile profile = own ? profile_of({dialect, false}) : machine(dialect, false);
          const bool lies = axis[0] != '0' || axis[2] != '0';
          const std::string end = std::string(",") + axis + "\n";
          const std::string text = "UNITS/MM\nLOADTL/3\nRAPID\nGOTO/0,0,10" + end +
                                   "FEDRAT/100,MMPM\nCUTCOM/" + side + "\nGOTO/1,2,3" + end + "GOTO/" +
                                   (axis[0] != '0' ? "1,7,9"
                                    : lies         ? "7,2,9"
                                                   : "7,9,3") +
                                   end + "FINI\n";
          const AptProgram stated = read(text);
          const auto program = program_text(stated, profile, on_table());
          // A head B lays the tool along X: LinuxCNC shifts in X Y and Z X alone, the others in X Y.
          const bool serves = !lies || dialect == Dialect::kFanuc || (dialect == Dialect::kRs274 && !own);
          ASSERT_EQ(program.has_value(), serves) << (program ? *program : program.error().message);
          if (!serves) {
            EXPECT_NE(program.error().message.find("the tool is not along Z there"), std::string::npos);
            continue;
          }
          planes += lies;
          EXPECT_NEAR(side_of(*program, profile, stated.operations[0]), side == "LEFT" ? 1.0 : -1.0, 1e-3)
              << *program;
          EXPECT_EQ(program->find(own ? "\nG19\n" : "\nG18\n") != std::string::npos, lies) << *program;
          EXPECT_EQ(program->find("\nG40\nG17\n") != std::string::npos, lies) << *program;
          const auto made = back(*program, profile);
          ASSERT_TRUE(made) << made.error().message;
          EXPECT_EQ(made->operations[0].events[0].kind,
                    side == "LEFT" ? EventKind::kCutterLeft : EventKind::kCutterRight);
        }
  EXPECT_EQ(planes, 2 * 2 * 4 + 2 * 4);
}

/// CAMWorks' files, where they are at hand: each is posted right, compensation included. One of them never
/// ends its cycle, and is refused.
TEST(PostModels, RealFilesAreTheirPrograms) {
  const std::string folder = SOURCE_DIR "/../shared/models/apt";
  if (!std::filesystem::exists(folder)) return;
  int right = 0, files = 0;
  MachineProfile profile = machine(Dialect::kRs274, false);
  for (LinearAxis* axis : {&profile.model.x, &profile.model.y, &profile.model.z})
    axis->min = -2000, axis->max = 2000;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".apt") continue;
    SCOPED_TRACE(entry.path().filename().string());
    ++files;
    std::ifstream file(entry.path());
    std::stringstream content;
    content << file.rdbuf();
    const auto program = read_apt(content, "in.cls", {0.0, 120.0});
    if (!program) {
      EXPECT_NE(program.error().message.find("while CYCLE/ is on"), std::string::npos)
          << program.error().message;
      continue;
    }
    content.clear();
    content.seekg(0);
    const auto text = program_text(*program, profile, on_table());
    ASSERT_TRUE(text) << text.error().message;
    const auto made = back(*text, profile);
    ASSERT_TRUE(made) << made.error().message;
    WayOfProgram(*made, kTip, kAxis).expect(AptJudge(content).corners());
    if (HasFatalFailure()) return;
    ++right;
  }
  EXPECT_GE(10 * right, 9 * files) << right << " of " << files;
}

}  // namespace
}  // namespace tiltfeed
