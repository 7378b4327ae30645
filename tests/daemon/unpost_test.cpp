// What is taken back from a program: the set-up from its header or as stated, and the length of its tools.

#include "daemon/post/unpost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>

#include "daemon/post/text_drawing.h"
#include "daemon/post/tool_length.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

TEST(ToolLength, AnotherThanTheProgramsIsRefused) {
  const std::string path = testing::TempDir() + "/tool_length.nc";
  for (const bool tcp : {false, true}) {
    const auto text = program_text(foreign(), machine(Dialect::kSiemens, tcp), setup());
    ASSERT_TRUE(text);
    std::ofstream(path, std::ios::binary) << *text;
    EXPECT_TRUE(check_tool_length(path, 100.0));
    EXPECT_TRUE(check_tool_length(path, 80.0)) << "the second tool";
    const auto other = check_tool_length(path, 99.0);
    EXPECT_EQ(other.has_value(), tcp) << "under TCP the control takes its own";
    if (!other) {
      EXPECT_NE(other.error().message.find("100, 80 mm, the tool in the spindle is 99 mm"),
                std::string::npos);
    }
  }
  std::ofstream(path, std::ios::binary) << "G0 X1\n";
  EXPECT_TRUE(check_tool_length(path, 99.0)) << "a program that says nothing";
  EXPECT_EQ(check_tool_length("/nonexistent.nc", 1.0).error().code, Code::kIo);
}

TEST(ToolLength, APlaneProgramIsForThePlannedLength) {
  MachineProfile profile = machine(Dialect::kHeidenhain, false);
  profile.format.tilted_planes = true;
  std::istringstream in(
      "UNITS/MM\nMULTAX\nLOADTL/3,LENGTH,80\nRAPID\nGOTO/0,0,20,0,0.6,0.8\nFEDRAT/400,MMPM\nGOTO/0,0,0\n"
      "RAPID\nGOTO/0,0,20\nFINI\n");
  const auto stated = read_apt(in, "in.cls", {});
  ASSERT_TRUE(stated) << stated.error().message;
  const auto text = program_text(*stated, profile, setup());
  ASSERT_TRUE(text) << text.error().message;
  ASSERT_NE(text->find("planes take the control's"), std::string::npos) << *text;
  const std::string path = testing::TempDir() + "/plane_length.nc";
  std::ofstream(path, std::ios::binary) << *text;
  EXPECT_TRUE(check_tool_length(path, 80.0));
  const auto other = check_tool_length(path, 81.0);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("planned for a tool of 80 mm"), std::string::npos)
      << other.error().message;
  EXPECT_NE(other.error().message.find("on a slant"), std::string::npos) << other.error().message;
}

TEST(Unpost, CrAlone_IsALineEnd) {
  const MachineProfile profile = machine(Dialect::kRs274, false);
  UnpostOptions options;
  options.part_zero = Vec3{0, 0, 0};
  options.tool_length = 50.0;
  const std::string lf = "G21 G90\n; a comment\nG0 X0 Y0 Z50 A0 C0\nG1 Z0 F100\nG1 X7\nM2\n";
  std::string cr = lf, both = lf;
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  for (std::size_t at = 0; (at = both.find('\n', at)) != both.npos; at += 2) both.insert(at, "\r");
  const auto expected = back(lf, profile, options);
  ASSERT_TRUE(expected) << expected.error().message;
  for (const std::string& text : {cr, both}) {
    const auto made = back(text, profile, options);
    ASSERT_TRUE(made) << made.error().message;
    const auto &moves = made->operations[0].path.moves, &same = expected->operations[0].path.moves;
    ASSERT_EQ(moves.size(), same.size());
    EXPECT_EQ(moves.back().pose.tip.x, 7.0);
  }
}

TEST(Unpost, WithoutAHeaderTheSetUpMustBeStated) {
  const MachineProfile profile = machine(Dialect::kRs274, false);
  const std::string text = "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 Z0 F100\nG1 A10\nM2\n";
  const auto no_zero = back(text, profile);
  ASSERT_FALSE(no_zero);
  EXPECT_NE(no_zero.error().message.find("--part-zero"), std::string::npos);
  UnpostOptions options;
  options.part_zero = Vec3{0, 0, 0};
  const auto no_length = back(text, profile, options);
  ASSERT_FALSE(no_length);
  EXPECT_NE(no_length.error().message.find("--tool-length"), std::string::npos);
  options.tool_length = 50.0;
  const auto made = back(text, profile, options);
  ASSERT_TRUE(made) << made.error().message;
  // The head turns about its pivot, 200 mm above the tip: the tip swings on a circle, which is what comes
  // out.
  const Point<Part> last = made->operations[0].path.moves.back().pose.tip;
  const double a = Angle::from_degrees(10).radians();
  EXPECT_NEAR(last.y, 200 * std::sin(a), 1e-9);
  EXPECT_NEAR(last.z, 200 * (1 - std::cos(a)), 1e-9);
  for (const Move& move : made->operations[0].path.moves)
    EXPECT_TRUE(move.pose.axis.z == 1.0 ||
                std::abs(std::hypot(move.pose.tip.y, move.pose.tip.z - 200.0) - 200.0) < 1e-9)
        << "on the circle";
  EXPECT_GT(made->operations[0].path.moves.size(), 20u);
}

/// The drawing of what is read back from a program: its records.
std::vector<std::array<float, kTextNumbers>> drawing_of(const AptProgram& read) {
  std::ostringstream out;
  write_text_drawing(read, out);
  const std::string bytes = out.str();
  std::vector<std::array<float, kTextNumbers>> records(bytes.size() / sizeof(float) / kTextNumbers);
  EXPECT_EQ(bytes.size(), records.size() * sizeof records[0]);
  std::memcpy(records.data(), bytes.data(), bytes.size());
  return records;
}

// Every place of the CL text is drawn, in its order, and leads to the program's line whose words make it.
TEST(TextDrawing, HasThePlacesOfTheClTextAndTheLinesThatMakeThem) {
  for (const bool tcp : {false, true}) {
    const MachineProfile profile = machine(Dialect::kSiemens, tcp);
    const auto text = program_text(foreign(), profile, setup());
    ASSERT_TRUE(text) << text.error().message;
    const auto read = back(*text, profile);
    ASSERT_TRUE(read) << read.error().message;
    const auto points = drawing_of(*read);
    std::size_t at = 0;
    for (const AptOperation& op : foreign().operations)
      for (const Move& move : op.path.moves) {
        const auto is_there = [&](const std::array<float, kTextNumbers>& p) {
          return std::hypot(p[0] - move.pose.tip.x, p[1] - move.pose.tip.y, p[2] - move.pose.tip.z) < 0.01 &&
                 std::hypot(p[3] - move.pose.axis.x, p[4] - move.pose.axis.y, p[5] - move.pose.axis.z) < 1e-3;
        };
        const auto found =
            std::find_if(points.begin() + static_cast<std::ptrdiff_t>(at), points.end(), is_there);
        ASSERT_NE(found, points.end()) << move.pose.tip.x << " " << move.pose.tip.y << " " << move.pose.tip.z;
        at = static_cast<std::size_t>(found - points.begin());
      }
    std::vector<std::string> lines{""};
    std::istringstream in(*text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    float before = 0.0f;
    for (const auto& p : points) {
      ASSERT_GE(p[7], before);
      before = p[7];
      const std::string& line = lines.at(static_cast<std::size_t>(p[7]));
      EXPECT_NE(line.find_first_of("XYZAC"), std::string::npos) << line;
      if (line.find("G0") != line.npos || line.find("G1") != line.npos) {
        EXPECT_EQ(p[6] == 0.0f, line.find("G0") != line.npos) << line;
      }
    }
  }
}

TEST(Unpost, FixtureAnglesComeBackFromTheHeader) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> angle(-180.0, 180.0);
  for (int round = 0; round < 200; ++round) {
    Vec3 degrees{angle(random), angle(random) / 2.0, angle(random)};
    if (round % 4 == 0)
      degrees = {90.0 * (round / 4 % 4), 90.0 * (round / 16 % 3 - 1), 90.0 * (round / 8 % 4)};
    PostOptions options;
    options.setup.fixture = fixture_of(degrees);
    std::istringstream in("LOADTL/1,LENGTH,50\nGOTO/0,0,10\nFINI\n");
    MachineProfile profile = machine(Dialect::kRs274, false);
    profile.model.tilt.min = -360, profile.model.tilt.max = 360;
    profile.model.x = profile.model.y = profile.model.z = {-2000, 2000, 9000, 1000};
    const auto text = program_text(*read_apt(in, "in.cls", {}), profile, options);
    ASSERT_TRUE(text) << text.error().message;
    std::istringstream program(*text);
    const auto read = read_nc_program(program, "x.nc", {Dialect::kRs274, 'A', 'C'});
    ASSERT_TRUE(read) << read.error().message;
    const Rotation turned = fixture_of(read->operations[0].fixture_deg.value_or(Vec3{}));
    for (std::size_t row = 0; row < 3; ++row)
      ASSERT_LE(length(turned.rows[row] - options.setup.fixture.rows[row]), 1e-10) << *text;
  }
}

/// An axis beside ours, as the quill W, stands where a line of the profile puts it.
TEST(Unpost, AnAxisBesideOursMovesInTheProfilesOwnLineAlone) {
  const std::pair<Dialect, std::vector<std::string>> cases[] = {
      {Dialect::kRs274, {"G53 G0 W0"}},          {Dialect::kGrbl, {"G53 G0 W-20.5"}},
      {Dialect::kFanuc, {"G53 G0 W0."}},         {Dialect::kFanuc, {"G91 G28 W0.", "G90"}},
      {Dialect::kHaas, {"G53 G0 W0."}},          {Dialect::kSiemens, {"SUPA G0 W=0 D0"}},
      {Dialect::kSiemens, {"SUPA G0 U10"}},      {Dialect::kHeidenhain, {"L W+0 R0 FMAX M91"}},
      {Dialect::kHeidenhainIso, {"G00 W+0 M91"}}};
  for (const auto& [dialect, lines] : cases) {
    MachineProfile with = machine(dialect, false);
    const auto plain = program_text(foreign(), with, setup());
    ASSERT_TRUE(plain) << plain.error().message;
    const auto expected = back(*plain, with);
    ASSERT_TRUE(expected) << expected.error().message;
    with.format.start = lines;
    const auto text = program_text(foreign(), with, setup());
    ASSERT_TRUE(text) << text.error().message;
    ASSERT_NE(text->find(lines.front()), std::string::npos) << *text;
    const auto made = back(*text, with);
    ASSERT_TRUE(made) << lines.front() << ": " << made.error().message;
    ASSERT_EQ(made->operations.size(), expected->operations.size());
    for (std::size_t i = 0; i < made->operations.size(); ++i) {
      const auto &moves = made->operations[i].path.moves, &same = expected->operations[i].path.moves;
      ASSERT_EQ(moves.size(), same.size());
      for (std::size_t k = 0; k < moves.size(); ++k)
        ASSERT_EQ(length(moves[k].pose.tip - same[k].pose.tip), 0.0) << lines.front();
    }
    // Any other line that moves it is refused, and so is this one of another machine.
    std::string other = *text;
    const std::size_t word = other.find(lines.front()) + lines.front().find_first_of("UW") + 1;
    other.insert(other[word] == '=' || other[word] == '+' ? word + 1 : word, "1");
    EXPECT_FALSE(back(other, with)) << other;
    with.format.start.clear();
    EXPECT_FALSE(back(*text, with)) << lines.front();
  }
}

}  // namespace
}  // namespace tiltfeed
