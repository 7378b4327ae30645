// What `tiltfeed verify` cannot judge is refused by name, before work starts: one case a kind of bad input.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "sim/report/verify_command.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

/// Of the test's own: they run side by side.
std::string folder() {
  return BINARY_DIR "/removal_refusals/" +
         std::string(testing::UnitTest::GetInstance()->current_test_info()->name());
}

void write(const std::string& name, const std::string& text) {
  std::ofstream(folder() + "/" + name, std::ios::binary) << text;
}

void write_box(const std::string& name, Vec3 low, Vec3 high) {
  std::vector<std::array<Point<Part>, 3>> facets;
  const Mesh mesh = box_mesh({{low, high}});
  for (const auto& f : mesh.facets)
    facets.push_back({mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]});
  ASSERT_TRUE(write_stl(folder() + "/" + name, facets));
}

const std::string kHead =
    "(TILTFEED part plate D4 L100)\n(TILTFEED machine generic-ac)\nG21 G90 G94\nG0 X0 Y0 Z20 A0 C0\n";
const std::string kGood = kHead + "G1 X1 Z2.2 F800\nG1 X2\nG0 Z20\nM2\n";

struct Said {
  int status = 0;
  std::string out, error;
  bool worked = false;  ///< a folder for the report was made
};

Said verify(VerifyOptions options, bool with_report = true) {
  Said said;
  options.job = folder() + "/job.yaml";
  if (with_report) options.out = folder() + "/report";
  if (!options.resolution) options.resolution = 0.5;
  std::filesystem::remove_all(folder() + "/report");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  said.status = verify_command(options);
  said.out = testing::internal::GetCapturedStdout();
  said.error = testing::internal::GetCapturedStderr();
  said.worked = std::filesystem::exists(folder() + "/report");
  return said;
}

class RemovalRefusal : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder());
    write_box("plate.stl", {-8, -4, -6}, {8, 4, 0});
    write_box("large.stl", {-9, -5, -7}, {9, 5, 2});
    write_box("short.stl", {-9, -5, -7}, {9, 3, 2});
    write("job.yaml", "part: {name: plate, stl: " + folder() +
                          "/plate.stl}\n"
                          "cutter: {type: ball, diameter_mm: 4, length_mm: 100, shank_length_mm: 40}\n"
                          "axis: {mode: fixed}\n"
                          "pattern: {along: x, direction: zigzag, side_step_mm: 0.4}\n"
                          "tolerance_mm: 0.01\nallowance_mm: 0\nclearance_mm: 5\napproach_mm: 1\n"
                          "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 1000}\n"
                          "setup: {part_zero_mm: [0, 0, 100]}\n"
                          "machine: " SOURCE_DIR "/config/machines/generic-ac.yaml\n");
    write("good.nc", kGood);
  }
};

// A program is executed while it is read; what is said first is not what is met first.
TEST_F(RemovalRefusal, WhatCannotBeReadIsSaidBeforeWhatDoesNotFit) {
  const std::string far = "G1 X5000 F800\n", other_tool = "T7 M6\nG1 X2 F800\n", arc = "G2 X3\n",
                    end = "M2\n";
  const auto said = [&](const std::string& text) {
    write("bad.nc", kHead + text);
    VerifyOptions options;
    options.program = folder() + "/bad.nc";
    const Said result = verify(options);
    EXPECT_EQ(result.status, 1) << text;
    EXPECT_FALSE(result.worked) << text;
    return result.error;
  };
  const std::string name = folder() + "/bad.nc";
  EXPECT_NE(said(far + other_tool + arc + end).find(name + ":8: "), std::string::npos);
  EXPECT_NE(said(other_tool + far + arc + end).find(name + ":8: "), std::string::npos);
  EXPECT_NE(said(far + other_tool + end).find("line 7 moves with tool T7"), std::string::npos);
  EXPECT_NE(said(other_tool + far + end).find("line 6 moves with tool T7"), std::string::npos);
  EXPECT_NE(said(far + "G1 X6000\n" + end).find("line 5: X 5000"), std::string::npos);
  EXPECT_NE(said("G1 Z19.9 F800\nG2\nG3\n").find(name + ":6: 'G2'"), std::string::npos);
}

TEST_F(RemovalRefusal, WhatIsRightIsJudged) {
  VerifyOptions options;
  options.program = folder() + "/good.nc", options.stock = folder() + "/large.stl";
  const Said said = verify(options, false);
  EXPECT_EQ(said.error, "");
  EXPECT_NE(said.out.find("largest gouge"), std::string::npos) << said.out;
}

TEST_F(RemovalRefusal, ProgramsByTheWordThatIsWrong) {
  const auto with = [](const std::string& line) { return kHead + "G1 X1 Z2.2 F800\n" + line + "\nM2\n"; };
  struct Case {
    const char* what;
    std::string program;
    std::vector<const char*> words;
  };
  const std::vector<Case> cases{
      {"another machine",
       "(TILTFEED machine other-bc)\n" + kGood.substr(kGood.find("G21")),
       {"machine other-bc", "generic-ac"}},
      {"another part", "(TILTFEED part pin D4 L100)\nG0 X1\nG0 X2\n", {"part pin", "plate"}},
      {"a tool that the job does not have, by diameter",
       "(TILTFEED part plate D4.05 L100)\nG0 X1\nG0 X2\n",
       {"diameter 4.05 mm", "has 4 mm"}},
      {"and by length",
       "(TILTFEED part plate D4 L100.02)\nG0 X1\nG0 X2\n",
       {"length 100.02 mm", "has 100 mm"}},
      {"another tool in the spindle", kHead + "T5 M6\nG1 X1 Z2.2 F800\nM2\n", {"bad.nc", "line 6", "T5"}},
      {"inches", with("G20"), {"bad.nc:6", "G20", "inches"}},
      {"an arc that ends beside its circle", with("G2 X2 Y2 I1 F100"), {"bad.nc:6", "the arc begins 1 mm"}},
      {"an arc without an end", with("G3"), {"bad.nc:6", "'G3'"}},
      {"an arc of another plane",
       with("G18\nG3 X2 Z1 I1 J1 F100"),
       {"bad.nc:7", "J is no word of an arc in G18"}},
      {"an unknown letter", with("G1 X2 B5 F100"), {"bad.nc:6", "B"}},
      {"an unknown code", with("G68 X2"), {"bad.nc:6", "G68"}},
      {"tool centre point control", with("G43.4 H1"), {"bad.nc:6", "G43.4"}},
      {"relative words", with("G91"), {"bad.nc:6", "G91"}},
      {"a number that is none", with("G1 X2.2.2 F100"), {"bad.nc:6", "X"}},
      {"beyond the travel", with("G1 X900 F100"), {"line 6", "X 900"}},
      {"no motion", "(TILTFEED part plate D4 L100)\nG21\nM2\n", {"bad.nc", "no motion"}},
      {"nothing", "", {"bad.nc"}},
  };
  for (const Case& c : cases) {
    write("bad.nc", c.program);
    VerifyOptions options;
    options.program = folder() + "/bad.nc";
    const Said said = verify(options);
    EXPECT_EQ(said.status, 1) << c.what;
    EXPECT_EQ(said.out, "") << c.what;
    EXPECT_FALSE(said.worked) << c.what;
    for (const char* word : c.words)
      EXPECT_NE(said.error.find(word), std::string::npos) << c.what << ": " << said.error;
  }
}

TEST_F(RemovalRefusal, StocksAndResolutions) {
  struct Case {
    const char* what;
    const char* stock;
    double resolution;
    int bundles;
    int status;
    const char* word;
  };
  const std::vector<Case> cases{
      {"a side of the part is outside", "/short.stl", 0.5, 1, 1, "does not hold the part"},
      {"no such file", "/absent.stl", 0.5, 1, 2, "absent.stl"},
      {"no such kind", "sphere:3", 0.5, 1, 2, "offset:MM"},
      {"finer than any", "box", 1e-5, 1, 2, "--resolution"},
      {"none at all", "box", 0.0, 1, 2, "--resolution 0: 0.001 to 50 mm"},
      {"not a number", "box", std::nan(""), 1, 2, "--resolution"},
      {"lines for more than there is", "box:20000", 0.01, 3, 1, "MB are free"},
  };
  for (const Case& c : cases) {
    VerifyOptions options;
    options.program = folder() + "/good.nc", options.resolution = c.resolution, options.bundles = c.bundles;
    options.stock = c.stock[0] == '/' ? folder() + c.stock : c.stock;
    const Said said = verify(options);
    EXPECT_EQ(said.status, c.status) << c.what << ": " << said.error;
    EXPECT_EQ(said.out, "") << c.what;
    EXPECT_FALSE(said.worked) << c.what;
    EXPECT_NE(said.error.find(c.word), std::string::npos) << c.what << ": " << said.error;
  }
}

TEST_F(RemovalRefusal, AResolutionWhoseProbesNeedMoreThanThereIs) {
  // The stock's lines would fit, the points on the part's surface do not.
  write_box("plate.stl", {-9000, -9000, -6}, {9000, 9000, 0});
  VerifyOptions options;
  options.program = folder() + "/good.nc", options.resolution = 0.002;
  const Said said = verify(options);
  EXPECT_EQ(said.status, 1);
  EXPECT_NE(said.error.find("MB for the part's surface"), std::string::npos) << said.error;
  EXPECT_FALSE(said.worked);
}

TEST_F(RemovalRefusal, CanonicalCommandsAndTraces) {
  struct Case {
    const char* text;
    bool trace;
    const char* word;
  };
  const std::vector<Case> cases{
      {"    1 N..... ARC_FEED(1.0, 1.0, 0.0, 0.0, 1, 0.0, 0.0, 0.0, 0.0)\n", false, "ARC_FEED"},
      {"    1 N..... USE_LENGTH_UNITS(CANON_UNITS_INCHES)\n", false, "inches"},
      {"block,line\n1,2\n", true, "bad.txt"},
      {"", true, "bad.txt"},
  };
  for (const Case& c : cases) {
    write("bad.txt", c.text);
    VerifyOptions options;
    (c.trace ? options.trace : options.canon) = folder() + "/bad.txt";
    const Said said = verify(options);
    EXPECT_EQ(said.status, 1) << c.text;
    EXPECT_NE(said.error.find(c.word), std::string::npos) << said.error;
    EXPECT_FALSE(said.worked) << c.text;
  }
}

TEST_F(RemovalRefusal, AFolderThatCannotBeMadeIsToldBeforeTheWork) {
  VerifyOptions options;
  options.program = folder() + "/good.nc", options.out = folder() + "/good.nc/report";
  const Said said = verify(options, false);
  EXPECT_EQ(said.status, 1);
  EXPECT_NE(said.error.find("the folder cannot be made"), std::string::npos) << said.error;
  EXPECT_EQ(said.out, "");
}

TEST_F(RemovalRefusal, CanonicalCommandsOfAnotherTool) {
  std::ifstream job(folder() + "/job.yaml");
  const std::string text{std::istreambuf_iterator<char>(job), {}};
  write("job.yaml", text + "program: {tool: 3}\n");
  for (const int tool : {3, 5}) {
    // What rs274 makes of T and M6.
    write("tool.txt", "    1 N..... SELECT_TOOL(" + std::to_string(tool) +
                          ")\n    2 N..... START_CHANGE()\n    3 N..... STOP_SPINDLE_TURNING(0)\n"
                          "    4 N..... CHANGE_TOOL(1)\n"
                          "    5 N..... STRAIGHT_TRAVERSE(0.0, 0.0, 20.0, 0.0, 0.0, 0.0)\n"
                          "    6 N..... STRAIGHT_TRAVERSE(1.0, 0.0, 20.0, 0.0, 0.0, 0.0)\n"
                          "    7 N..... PROGRAM_END()\n");
    VerifyOptions options;
    options.canon = folder() + "/tool.txt";
    const Said said = verify(options);
    EXPECT_EQ(said.error.find("moves with tool T5") != std::string::npos, tool == 5) << said.error;
    EXPECT_EQ(said.worked, tool == 3) << said.out;
  }
}

}  // namespace
}  // namespace tiltfeed::sim
