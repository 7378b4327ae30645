// Every dialect: text read back by two readers gives the words to the last digit; feeds; TCP by sampling;
// what the reader refuses.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "kinematics/basics/decimal.h"
#include "kinematics/timing/tcp_path.h"
#include "tests/judges/dialect_reader.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

/// A random program: words on the printed grid, some of them the same as before, some far away.
JointPath random_words(std::mt19937& random, const ProgramFormat& format, std::size_t count) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  JointPath path;
  Joints at{0, 0, 100, 0, 0};
  for (std::size_t i = 0; i < count; ++i) {
    const double step = std::pow(10.0, 2.5 * unit(random));
    const auto go = [&](double& value, int decimals) {
      if (random() % 3 == 0) return;
      const double next = value + step * unit(random);
      value = round_decimal(std::abs(next) < 900.0 ? next : 0.0, decimals);
    };
    go(at.x, format.linear_decimals), go(at.y, format.linear_decimals), go(at.z, format.linear_decimals);
    go(at.a, format.rotary_decimals), go(at.c, format.rotary_decimals);
    if (i > 0 && at == path.moves.back().joints) continue;
    const auto kind = i == 0 ? MoveKind::kRapid : static_cast<MoveKind>(random() % 3);
    path.moves.push_back({at, 0.01 + std::abs(unit(random)), kind, static_cast<std::uint32_t>(i)});
  }
  return path;
}

class Dialects : public testing::TestWithParam<DialectCase> {};
INSTANTIATE_TEST_SUITE_P(All, Dialects, testing::ValuesIn(dialect_cases()), case_name);

// (dialect.h, properties 1 and 3)
TEST_P(Dialects, RandomProgramsReadBackToTheLastDigit) {
  std::mt19937 random(7);
  for (int round = 0; round < 12; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    Posting posting = posting_of(GetParam(), {});
    ProgramFormat& format = posting.machine.format;
    format.linear_decimals = 1 + round % 6;
    format.rotary_decimals = 1 + (round / 2) % 6;
    format.line_numbers = round % 2 == 1;
    format.line_number_step = 1 + round % 7;
    format.crlf = round % 5 == 4;
    format.max_line_length = 140;
    const JointPath first = random_words(random, format, 1200), second = random_words(random, format, 50);
    const ProgramFormat kept = format;
    posting = posting_of(GetParam(), {&first, &second});
    posting.machine.format = kept;
    const std::string text = text_of(posting);
    const bool heidenhain = kept.dialect == Dialect::kHeidenhain;
    const SeenProgram seen = seen_program(text, heidenhain, 'B', 'C');
    EXPECT_EQ(seen.trouble, "");
    std::istringstream in(text);
    const auto read = read_nc_program(in, "x.nc", language_of(posting.machine));
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->operations.size(), 2u);
    std::size_t at = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto& moves = (k == 0 ? first : second).moves;
      const TextOperation& op = read->operations[k];
      EXPECT_EQ(op.tool_number, 3 + static_cast<int>(k));
      EXPECT_EQ(op.tool_length, posting.operations[k].tool.length);
      EXPECT_EQ(op.part_zero, (Vec3{20, -10, 60.5}));
      const std::size_t start = blocks_before(GetParam(), op, moves.size());
      ASSERT_EQ(op.blocks.size(), start + moves.size());
      at += start;
      for (std::size_t i = 0; i < moves.size(); ++i, ++at) {
        const TextBlock& block = op.blocks[start + i];
        ASSERT_EQ(block.words, moves[i].joints) << "block " << i;
        ASSERT_EQ(block.rapid, moves[i].kind == MoveKind::kRapid) << "block " << i;
        ASSERT_EQ(block.tcp, GetParam().tcp);
        ASSERT_LT(at, seen.blocks.size());
        ASSERT_EQ(seen.blocks[at].words, moves[i].joints) << "block " << i;
        ASSERT_EQ(seen.blocks[at].rapid, moves[i].kind == MoveKind::kRapid) << "block " << i;
        ASSERT_TRUE(i > 0 || seen.blocks[at].whole == GetParam().tcp) << "TCP begins with all five words";
      }
    }
  }
}

/// What each control makes of F, worked out here once more.
// (dialect.h, property 2)
TEST_P(Dialects, FeedsGiveTheTimesOfTheBlocks) {
  std::mt19937 random(11);
  for (const FeedMode mode : {FeedMode::kInverseTime, FeedMode::kPerMinute}) {
    for (const FeedMeasure measure : {FeedMeasure::kXyz, FeedMeasure::kDegrees, FeedMeasure::kRadius}) {
      if (mode == FeedMode::kInverseTime && !has_inverse_time(GetParam().dialect)) continue;
      Posting posting = posting_of(GetParam(), {});
      ProgramFormat format = posting.machine.format;
      format.feed_mode = mode;
      format.feed_measure = measure;
      format.feed_radius = 50.0;
      format.max_feed = format.max_inverse_time = 1e7;
      const JointPath path = random_words(random, format, 400);
      posting = posting_of(GetParam(), {&path});
      posting.machine.format = format;
      const std::string text = text_of(posting);
      if (has_inverse_time(GetParam().dialect)) {
        EXPECT_LT(text.find(mode == FeedMode::kInverseTime && !GetParam().tcp ? "G93" : "G94"),
                  text.find(" F"))
            << "the feed mode is stated before the first F";
      }
      std::istringstream in(text);
      const auto read = read_nc_program(in, "x.nc", language_of(posting.machine));
      ASSERT_TRUE(read) << read.error().message;
      auto blocks = read->operations[0].blocks;
      const auto start = blocks_before(GetParam(), read->operations[0], path.moves.size());
      blocks.erase(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(start));
      for (std::size_t i = 1; i < blocks.size(); ++i) {
        const JointMove& move = path.moves[i];
        if (move.kind == MoveKind::kRapid) continue;
        const Joints &p = path.moves[i - 1].joints, &q = move.joints;
        const double xyz =
            std::sqrt((q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y) + (q.z - p.z) * (q.z - p.z));
        const double turn = std::sqrt((q.a - p.a) * (q.a - p.a) + (q.c - p.c) * (q.c - p.c));
        double want = 60.0 / move.seconds;
        const double per_minute = want;
        if (GetParam().tcp)
          want = xyz > 0.0 ? (move.kind == MoveKind::kCut ? 1500.0 : 400.0) : turn * per_minute;
        else if (mode == FeedMode::kPerMinute && measure == FeedMeasure::kXyz)
          want = (xyz > 0.0 ? xyz : turn) * per_minute;
        else if (mode == FeedMode::kPerMinute && measure == FeedMeasure::kDegrees)
          want = std::sqrt(xyz * xyz + turn * turn) * per_minute;
        else if (mode == FeedMode::kPerMinute)
          want = std::sqrt(xyz * xyz + turn * turn * std::pow(50.0 * kPi / 180.0, 2)) * per_minute;
        ASSERT_EQ(blocks[i].inverse_time, mode == FeedMode::kInverseTime && !GetParam().tcp);
        // Half of the fifth digit, or of the last decimal that the control has, whose least F is one of them.
        const double last = std::pow(10.0, -std::min(table_of(GetParam().dialect).feed_decimals, 5));
        ASSERT_NEAR(blocks[i].feed, want, std::max(kFeedError * want, want < last ? last : 0.51 * last))
            << text_of(posting).substr(0, 2000);
      }
    }
  }
}

TEST(Dialect, WordsModuloATurnAreCountedBack) {
  JointPath path;
  Joints at{0, 0, 100, 0, 0};
  std::mt19937 random(5);
  path.moves.push_back({at, 0.0, MoveKind::kRapid, 0});
  for (int i = 0; i < 2000; ++i) {
    at.c = round_decimal(at.c + static_cast<double>(static_cast<int>(random() % 3001) - 1500) / 10.0, 3);
    at.x = round_decimal(at.x + 0.001, 3);
    if (std::fmod(at.c, 360.0) == 0.0) at.c += 0.5;
    path.moves.push_back({at, 1.0, MoveKind::kCut, 0});
  }
  for (const RotaryWord word : {RotaryWord::kShortest, RotaryWord::kSigned}) {
    Posting posting = posting_of({Dialect::kFanuc, false}, {&path});
    posting.machine.model.rotary.word = word;
    std::istringstream in(text_of(posting));
    const auto read = read_nc_program(in, "x.nc", language_of(posting.machine));
    ASSERT_TRUE(read) << read.error().message;
    for (std::size_t i = 0; i < path.moves.size(); ++i)
      ASSERT_NEAR(read->operations[0].blocks[i].words.c, path.moves[i].joints.c, 1e-9) << "block " << i;
  }
}

/// Under TCP the control turns the rotaries linearly and keeps the tip on a straight line: the axis, densely
/// sampled, must be that of the joint path.
TEST(Tcp, JoinedBlocksKeepTipAndAxis) {
  const MachineProfile profile = profile_of({Dialect::kSiemens, true});
  tiltfeed::Setup setup;
  setup.part_zero = {20, -10, 60};
  setup.fixture = rotation_about(normalized(Vec3{1, 2, 3}), 0.3);
  setup.tool_length = 100;
  ToolPath tool_path;
  tool_path.tool = {6, 3, 100};
  tool_path.cut_feed = tool_path.plunge_feed = Feed::from_mm_per_min(1500);
  for (int i = 0; i < 60; ++i) {
    const double t = 0.2 * i, tilt = 0.5 + 0.45 * std::sin(0.3 * t);
    const Vec3 axis =
        normalized(Vec3{std::sin(tilt) * std::cos(t), std::sin(tilt) * std::sin(t), std::cos(tilt)});
    tool_path.moves.push_back(
        {{Point<Part>{0, 0, 1.0 * i} + axis * 20.0, axis}, i ? MoveKind::kCut : MoveKind::kRapid, kNoFacet});
  }
  JointPathOptions options;
  options.linear_decimals = 6;
  options.axis_tolerance = 0.02;
  const auto joints = to_joints(tool_path, profile.model, setup, options);
  ASSERT_TRUE(joints) << joints.error().message;
  const JointPath words = words_under_tcp(*joints, profile.model, setup, {4, 0.05});
  EXPECT_LT(words.moves.size(), joints->moves.size() / 2) << "blocks that only held the tip are left out";
  double worst_axis = 0.0, worst_tip = 0.0, seconds = 0.0;
  for (std::size_t i = 1; i < words.moves.size(); ++i) {
    const JointMove &from = words.moves[i - 1], &to = words.moves[i];
    // Turning in place at the pole has no way of the tip to measure the axis by.
    seconds += to.seconds;
    const Pose &a = tool_path.moves[to.move - 1].pose, &b = tool_path.moves[to.move].pose;
    for (int s = 0; s <= 20; ++s) {
      const double f = s / 20.0;
      const Joints between{from.joints.x + f * (to.joints.x - from.joints.x),
                           from.joints.y + f * (to.joints.y - from.joints.y),
                           from.joints.z + f * (to.joints.z - from.joints.z),
                           from.joints.a + f * (to.joints.a - from.joints.a),
                           from.joints.c + f * (to.joints.c - from.joints.c)};
      const Pose pose = pose_under_tcp(profile.model, setup, between);
      worst_tip = std::max(worst_tip, distance_to_segment(pose.tip, a.tip, b.tip));
      const double g =
          std::clamp(dot(pose.tip - a.tip, b.tip - a.tip) / squared_length(b.tip - a.tip), 0.0, 1.0);
      worst_axis = std::max(worst_axis, angle_between(pose.axis, slerp(a.axis, b.axis, g)));
    }
  }
  EXPECT_LE(worst_tip, options.tolerance + 1e-4);
  EXPECT_LE(worst_axis, Angle::from_degrees(0.05 + 0.02 + 0.005).radians());
  EXPECT_NEAR(seconds, joints->report.seconds, 1e-9 * seconds);
}

TEST(ProgramText, BadInputIsNamedWithItsLine) {
  const struct {
    const char* text;
    const char* message;
  } table[]{
      {"", "x.nc:0: no motion block"},
      {"G0 X1\n", "x.nc:1: no motion block"},
      {"G20\n", "x.nc:1: the program is in inches"},
      {"G0 X0 Y0 Z0 B0 C0\nG2 X1 Y1 F9\n", "x.nc:2: an arc without I and J"},
      {"G0 X0 Y0 Z0 B0 C0\nG2 X1 I0.4 F9\n", "x.nc:2: the arc begins 0.4 mm from its centre and ends 0.6"},
      {"G0 X0 Y0 Z0 B0 C0\nG2 X0 I0.4 F9\n", "x.nc:2: a full circle"},
      {"G0 X0 Y0 Z0 B0 C0\nG2 X1 I0.5 K0 F9\n", "x.nc:2: K is no word of an arc in G17"},
      {"G0 X0 Y0 Z0 B0 C0\nG1 X1 I0.5 F9\n", "x.nc:2: I is understood in arcs"},
      {"G0 X0 Y0 Z0 B0 C0\nG2 X1 Z1 I0.5 F9\n", "x.nc:2: an arc in which another axis"},
      {"G0 X0 Y0 Z0 B0 C0\nG2 X1 R1 F9\n", "x.nc:2: R is not"},
      {"G81 X1 Z1\n", "x.nc:1: G81 is not understood"},
      {"X1 Y2\n", "x.nc:1: axis words before"},
      {"G1 X1 F100\n", "x.nc:1: a feed move before all five"},
      {"G0 X0 Y0 Z0 B0 C0\nG93\nG1 X1\n", "x.nc:3: no F"},
      {"G0 X0 Y0 Z0 B0 C0\nG1 X1\n", "x.nc:2: a feed move without F"},
      {"G0 X0 Y0 Z0 B0 C0\nG91\nG0 X1\n", "x.nc:3: incremental"},
      {"G0 X0 Y0 Z0 B0 C0 U1\n", "x.nc:1: U is no word"},
      {"G0 X1e3\n", "x.nc:1: "},
      {"G0 X0 X1\n", "x.nc:1: X stands twice"},
      {"G0 (open\n", "x.nc:1: comment"},
      {"WHILE X1\n", "x.nc:1: \"WHILE\" is not understood"},
      {"G0 XNAN\n", "x.nc:1: "}};
  for (const auto& row : table) {
    std::istringstream in(row.text);
    const auto read = read_nc_program(in, "x.nc", {Dialect::kRs274, 'B', 'C'});
    ASSERT_FALSE(read) << row.text;
    EXPECT_EQ(read.error().message.rfind(row.message, 0), 0u) << read.error().message;
  }
}

}  // namespace
}  // namespace tiltfeed
