// Joint paths through, past and about the pole, where the table's angle has no meaning; and random paths that
// come there often.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "tests/judges/joint_path_check.h"
#include "tests/samples.h"

namespace tiltfeed {
namespace {

using namespace joint_check;

TEST(JointPole, ConeThroughThePole) {
  const Rotation incline = rotation_about({0, 1, 0}, Angle::from_degrees(15).radians());
  JointPath joints;
  expect_good(sampled(720,
                      [&](double f) {
                        const Vec3 axis =
                            rotation_about(incline * Vec3{0, 0, 1}, 2 * kPi * f) * (incline * axis_at(15, 0));
                        return Pose{Point<Part>{} + axis * 30.0, normalized(axis)};
                      }),
              trunnion(), &joints);
  // The head goes through zero: the table turns by 180 degrees in all, smoothly, and never swings in place.
  EXPECT_NEAR(span(joints, &Joints::a), 60.0, 0.3);
  EXPECT_NEAR(span(joints, &Joints::c), 180.0, 1.0);
}

std::vector<Pose> past_the_pole(double distance_deg, double tilt_deg = 25) {
  // A great circle whose nearest approach to the pole is `distance_deg`.
  const double d = Angle::from_degrees(distance_deg).radians(), t = Angle::from_degrees(tilt_deg).radians();
  const Vec3 nearest{0, std::sin(d), std::cos(d)}, along{1, 0, 0};
  return {{{30, 0, 0}, normalized(nearest * std::cos(t) - along * std::sin(t))},
          {{40, 25, 0}, normalized(nearest * std::cos(t) + along * std::sin(t))}};
}

TEST(JointPole, CrossesThePole) {
  for (const double distance : {0.0, 1e-9, 0.001, 0.01, 0.05, 0.3, 2.0}) {
    for (const Vec3 head : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, std::sqrt(0.5), std::sqrt(0.5)}}) {
      SCOPED_TRACE(testing::Message() << distance << " degrees off, head y " << head.y);
      JointPath joints;
      expect_good(past_the_pole(distance), trunnion(head), &joints);
      if (distance < 0.02 && head.z == 0.0) {
        // The head goes through zero and the table stands nearly still.
        EXPECT_LT(span(joints, &Joints::c), distance < 1e-6 ? 0.001 : 60.0);
        EXPECT_NEAR(span(joints, &Joints::a), 50.0, 0.01);
        EXPECT_LT(joints.moves.size(), 120u);
      }
    }
  }
}

TEST(JointPole, CrossesThePoleWithAHeadThatEndsThere) {
  MachineModel m = trunnion();
  m.tilt.min = 0;
  for (const double distance : {0.0, 0.001, 0.01, 0.3}) {
    SCOPED_TRACE(testing::Message() << distance << " degrees off");
    JointPath joints;
    expect_good(past_the_pole(distance), m, &joints);
    EXPECT_NEAR(span(joints, &Joints::c), 180.0, 5.0);
    EXPECT_GE(joints.report.min.a, 0.0);
    if (distance < 0.02) {
      EXPECT_EQ(joints.report.pole_swings, 1u);
    }
  }
}

TEST(JointPole, SwingsBeforeAShortMoveUnderATightAxisTolerance) {
  // As round a blade's edge: upright after a way in one direction, on in another by a degree in 0.1 mm.
  JointPathOptions tight;
  tight.tolerance = 0.0035, tight.axis_tolerance = 0.004;
  for (const double azimuth : {30.0, 90.0, 140.0})
    for (const double side : {-35.0, 35.0}) {
      SCOPED_TRACE(testing::Message() << azimuth << ", " << side << " mm beside the table's centre");
      const auto tip = [&](double ahead) { return Point<Part>{-20, 10 + side + ahead, 0}; };
      std::vector<Pose> poses;
      for (double tilt = 20; tilt > 0.5; tilt -= 1.0) poses.push_back({tip(-tilt / 10), axis_at(tilt, 0)});
      poses.push_back({tip(0), {0, 0, 1}});
      for (double tilt = 1; tilt < 20; tilt += 1.0) poses.push_back({tip(tilt / 10), axis_at(tilt, azimuth)});
      JointPath joints;
      expect_good(poses, trunnion(), &joints, tight);
      EXPECT_EQ(joints.report.pole_swings, 1u);
      EXPECT_NEAR(span(joints, &Joints::c), std::min(azimuth, 180.0 - azimuth), 0.1);
    }
}

TEST(JointPole, NeverTurnsTheTableByHalfATurnInOneBlock) {
  // On the table's axis, nearly upright: a half turn would keep every tolerance and has no direction.
  MachineModel m = trunnion();
  m.tilt.min = 0;
  for (const double azimuth : {0.0, 37.0}) {
    JointPath joints;
    const Checked worst = expect_good(
        {{{-20, 10, 0}, axis_at(0.04, azimuth)}, {{-20, 10, 5}, axis_at(0.04, azimuth + 180)}}, m, &joints);
    EXPECT_NEAR(span(joints, &Joints::c), 180.0, 1e-3);
    EXPECT_LT(worst.largest_turn, 180.0);
  }
}

TEST(JointPole, CrossesThePoleWithoutLeaveToHold) {
  // So tight that the table must follow the axis round the pole.
  JointPathOptions options;
  options.tolerance = 0.0002;
  options.axis_tolerance = 0.001;
  options.linear_decimals = 6;
  options.rotary_decimals = 6;
  JointPath joints;
  expect_good(past_the_pole(0.001), trunnion(), &joints, options);
  EXPECT_NEAR(span(joints, &Joints::c), 180.0, 1.0);
}

/// Two plunges along the pole, each followed by a cut that leaves it: the rotary, which is free there, is
/// turned while the tool is in the air.
TEST(JointPole, TurnsTheFreeRotaryBeforeThePlunge) {
  ToolPath path;
  path.tool = {6, 3, 100};
  path.cut_feed = path.plunge_feed = Feed::from_mm_per_min(500);
  const auto go = [&](Point<Part> tip, Vec3 axis, MoveKind kind) {
    path.moves.push_back({{tip, normalized(axis)}, kind, kNoFacet});
  };
  for (const double azimuth : {70.0, -50.0}) {
    const Point<Part> at{azimuth / 10.0, 5, 0};
    go(at + Vec3{0, 0, 40}, {0, 0, 1}, MoveKind::kRapid);
    go(at, {0, 0, 1}, MoveKind::kPlunge);
    for (int i = 1; i <= 20; ++i) go(at + Vec3{0.5 * i, 0, 0}, axis_at(i, azimuth), MoveKind::kCut);
    go(at + Vec3{10, 0, 40}, axis_at(20, azimuth), MoveKind::kRapid);
  }
  const auto joints = to_joints(path, trunnion(), {}, {});
  ASSERT_TRUE(joints) << joints.error().message;
  EXPECT_EQ(joints->report.pole_swings, 0u);
  double in_air = 0.0;
  for (std::size_t i = 1; i < joints->moves.size(); ++i) {
    const double turn = std::abs(joints->moves[i].joints.c - joints->moves[i - 1].joints.c);
    if (joints->moves[i].kind == MoveKind::kRapid)
      in_air += turn;
    else
      ASSERT_LT(turn, 0.5) << "block " << i << " turns the table in the material";
  }
  EXPECT_GT(in_air, 50.0);
}

/// A nutating head leaves the pole along no meridian: the table stands where the first degree of a long move
/// wants it, not its end.
TEST(JointPole, TurnsTheFreeRotaryToWhereANutatingHeadLeavesThePole) {
  const double slope = std::sqrt(0.5);
  for (const double azimuth : {0.0, 70.0, -130.0}) {
    ToolPath path;
    path.tool = {6, 3, 100};
    path.cut_feed = path.plunge_feed = Feed::from_mm_per_min(500);
    const auto go = [&](Point<Part> tip, Vec3 axis, MoveKind kind) {
      path.moves.push_back({{tip, normalized(axis)}, kind, kNoFacet});
    };
    for (const double x : {0.0, 50.0}) {
      go({x, 5, 40}, {0, 0, 1}, MoveKind::kRapid);
      go({x, 5, 0}, {0, 0, 1}, MoveKind::kPlunge);
      go({x + 10, 5, 0}, axis_at(20, azimuth + x), MoveKind::kCut);
      go({x + 10, 5, 40}, axis_at(20, azimuth + x), MoveKind::kRapid);
    }
    const auto joints = to_joints(path, trunnion({0, slope, slope}), {}, {});
    ASSERT_TRUE(joints) << joints.error().message;
    double in_material = 0.0;  // the tilt standing
    for (std::size_t i = 1; i < joints->moves.size(); ++i) {
      const Joints &from = joints->moves[i - 1].joints, &to = joints->moves[i].joints;
      if (joints->moves[i].kind != MoveKind::kRapid && to.a == from.a) in_material += std::abs(to.c - from.c);
    }
    EXPECT_LT(in_material, 0.5);
  }
}

/// A trunnion that tilts far to one side only, as most do.
MachineModel one_sided() {
  MachineModel m = trunnion();
  m.structure = Structure::kTableTable;
  m.tilt = {'B', {0, 1, 0}, -1, 0.0, -35, 110, 18000, 500};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -1e6, 1e6, 36000, 900};
  m.rotary_to_tilt = {0.1, 0, 50.3};
  return m;
}

/// A cut, the tool off along its axis, its axis turned about the pole by a move of this kind, a cut.
ToolPath reversal(double azimuth, double turn, MoveKind over) {
  ToolPath path;
  path.tool = {6, 3, 100};
  path.cut_feed = path.plunge_feed = Feed::from_mm_per_min(800);
  const Vec3 before = axis_at(60, azimuth), after = axis_at(60, azimuth + turn);
  path.moves = {{{{0, 0, -10}, before}, MoveKind::kRapid, kNoFacet},
                {{{0, 0, -40}, before}, MoveKind::kPlunge, kNoFacet},
                {{{5, 0, -40}, before}, MoveKind::kCut, kNoFacet},
                {{{5, 0, -10}, before}, MoveKind::kRapid, kNoFacet},
                {{{5, 0, -10}, after}, over, kNoFacet},
                {{{9, 0, -10}, after}, MoveKind::kCut, kNoFacet}};
  return path;
}

/// Within the limits the joints come to every pose of the path in turn.
void expect_reaches_all(const ToolPath& path, const MachineModel& machine, const JointPath& joints) {
  std::size_t reached = 0;
  for (const JointMove& move : joints.moves) {
    EXPECT_TRUE(within_limits(machine, move.joints));
    const Pose pose = forward(machine, {}, move.joints);
    if (reached < path.moves.size() && distance(pose.tip, path.moves[reached].pose.tip) < 0.05 &&
        angle_between(pose.axis, path.moves[reached].pose.axis) < 0.01)
      ++reached;
  }
  EXPECT_EQ(reached, path.moves.size());
}

/// Below the clear height no rotary turns by more than a degree between two blocks, but within a cut.
void expect_turns_high(const MachineModel& machine, const JointPath& joints, double height) {
  for (std::size_t i = 1; i < joints.moves.size(); ++i)
    if (std::abs(joints.moves[i].joints.c - joints.moves[i - 1].joints.c) > 1.0) {
      EXPECT_GT(forward(machine, {}, joints.moves[i].joints).tip.z, height - 1.0);
    }
}

/// The axis turns over the pole by 180 degrees about it, in a rapid and in a cut, exactly and nearly; the
/// joints are those of another posture, and every pose of the path is reached.
TEST(JointPole, ReversalsOverThePoleAreFound) {
  for (const MoveKind over : {MoveKind::kRapid, MoveKind::kCut}) {
    for (const double turn : {179.9, 180.0, 181.0}) {
      for (const bool height : {false, true}) {
        const bool rapid = over == MoveKind::kRapid;
        SCOPED_TRACE(std::to_string(turn) + (rapid ? " rapid" : " cut") + (height ? " clear height" : ""));
        const ToolPath path = reversal(20, turn, over);
        JointPathOptions options;
        if (height) options.clear.height = 50.0;
        const MachineModel machine = one_sided();
        const auto joints = to_joints(path, machine, {}, options);
        ASSERT_TRUE(joints) << joints.error().message;
        expect_reaches_all(path, machine, *joints);
        if (height && rapid && turn == 180.0) expect_turns_high(machine, *joints, 50.0);
      }
    }
  }
}

/// A head of 45 degrees that tilts to one side only.
MachineModel one_sided_nutating() {
  const double slope = std::sqrt(0.5);
  MachineModel m = trunnion({0, slope, slope});
  m.tilt.min = -30, m.tilt.max = 180;
  return m;
}

/// Posts the reversal, holds every block to the path and, at the clear height, the table to its turns there.
void expect_reversal(const ToolPath& path, const MachineModel& machine, std::optional<double> height) {
  JointPathOptions options;
  options.clear.height = height;
  const auto joints = to_joints(path, machine, {}, options);
  ASSERT_TRUE(joints) << joints.error().message;
  expect_reaches_all(path, machine, *joints);
  if (!joints->reconfigured) return;
  check_densely(*joints->reconfigured, machine, {}, options, *joints);
  if (height) expect_turns_high(machine, *joints, *height);
}

constexpr std::pair<double, double> kLittleMoreThanATurn[] = {{0, 360}, {-10, 370}, {-180, 180}, {-200, 180}};

/// A rapid whose way by the great circle leads the rotary over a limit is made the other way round at the
/// clear height.
TEST(JointPole, RapidReversalsWithinALimitedRotary) {
  for (MachineModel machine : {one_sided(), one_sided_nutating()}) {
    for (const auto& [min, max] : kLittleMoreThanATurn) {
      machine.rotary.min = min, machine.rotary.max = max;
      for (const int azimuth : {0, 30, 37, 90, 135, 200, 270, 333}) {
        for (const double turn : {170.0, 179.9, 180.0, 181.0, 190.0}) {
          SCOPED_TRACE(std::to_string(turn) + " from " + std::to_string(azimuth) + " within " +
                       std::to_string(min) + " and " + std::to_string(max));
          expect_reversal(reversal(azimuth, turn, MoveKind::kRapid), machine, 50.0);
        }
      }
    }
  }
}

/// An exact half turn needs no clear height: at the pole the rotary is turned the way round that it has left.
TEST(JointPole, HalfTurnsWithinALimitedRotary) {
  MachineModel machine = one_sided();
  for (const auto& [min, max] : kLittleMoreThanATurn) {
    machine.rotary.min = min, machine.rotary.max = max;
    for (const int azimuth : {0, 30, 37, 90, 135, 200, 270, 333}) {
      for (const MoveKind over : {MoveKind::kRapid, MoveKind::kCut}) {
        SCOPED_TRACE(std::to_string(azimuth) + " within " + std::to_string(min) + " and " +
                     std::to_string(max) + (over == MoveKind::kRapid ? " rapid" : " cut"));
        expect_reversal(reversal(azimuth, 180.0, over), machine, std::nullopt);
      }
    }
  }
  // The rotary of a nutating head turns on from the pole: of two turns there one leads to the end.
  machine = one_sided_nutating();
  machine.rotary.min = -200, machine.rotary.max = 180;
  for (const MoveKind over : {MoveKind::kRapid, MoveKind::kCut})
    expect_reversal(reversal(0, 180.0, over), machine, std::nullopt);
}

/// An axis turned round to its opposite has no great circle: it goes by way of the pole.
TEST(JointPole, OppositeAxesGoByThePole) {
  ToolPath path;
  path.tool = {6, 3, 100};
  path.cut_feed = path.plunge_feed = Feed::from_mm_per_min(800);
  const Vec3 axis = axis_at(80, 0);
  path.moves = {{{{0, 0, -10}, axis}, MoveKind::kRapid, kNoFacet},
                {{{0, 0, -40}, axis}, MoveKind::kPlunge, kNoFacet},
                {{{5, 0, -40}, axis * -1.0}, MoveKind::kCut, kNoFacet}};
  const auto joints = to_joints(path, one_sided(), {}, {});
  ASSERT_TRUE(joints) << joints.error().message;
  const Pose end = forward(one_sided(), {}, joints->moves.back().joints);
  EXPECT_LT(angle_between(end.axis, axis * -1.0), 1e-4);
  EXPECT_LT(distance(end.tip, path.moves.back().pose.tip), 0.01);
}

/// Level axes all along have no place nearest to the pole: where the table cannot turn as far, that is said.
TEST(JointPole, LevelAxesPastTheTablesTravel) {
  MachineModel machine = trunnion();
  machine.rotary.min = -60.0, machine.rotary.max = 60.0;
  for (const double half_turn : {100.0, 150.0}) {
    std::vector<Pose> poses;
    for (double azimuth = -half_turn; azimuth <= half_turn; azimuth += 25.0) {
      const Angle a = Angle::from_degrees(azimuth);
      poses.push_back({{0, 0, -10}, {std::cos(a.radians()), std::sin(a.radians()), 0.0}});
    }
    const auto joints = to_joints(path_of(poses, MoveKind::kCut), machine, standing(), {});
    ASSERT_FALSE(joints);
    EXPECT_EQ(joints.error().code, Code::kLimit) << joints.error().message;
  }
}

TEST(JointPole, LeavesThePoleInAnyDirection) {
  for (int azimuth = -180; azimuth < 180; azimuth += 15) {
    JointPath joints;
    expect_good({{{10, 0, 0}, {0, 0, 1}},
                 {{20, 5, 0}, {0, 0, 1}},
                 {{30, 0, 5}, axis_at(30, azimuth)},
                 {{0, 0, 0}, {0, 0, 1}},
                 {{5, 0, 0}, {0, 0, 1}}},
                trunnion(), &joints);
    ASSERT_GE(joints.moves.size(), 2u);
    EXPECT_LE(span(joints, &Joints::c), 90.1) << "a head of both signs needs a quarter turn at most";
    // At the pole the table holds.
    EXPECT_EQ(joints.moves.back().joints.c, joints.moves[joints.moves.size() - 2].joints.c);
  }
}

TEST(JointPole, WandersAboutThePole) {
  expect_good(sampled(400,
                      [](double f) {
                        const double t = 2 * kPi * f;
                        return Pose{{20 * std::cos(t), 20 * std::sin(3 * t), 0},
                                    axis_at(0.2 * std::abs(std::sin(7 * t)), 400 * f)};
                      }),
              trunnion());
}

/// Fine moves with a long one past the pole now and then. The long one ends on the branch that it is led to,
/// not on the one nearest in time to its start; all that follows has to go on from there.
TEST(JointPole, ALongPathGoesOnFromWhereEachMoveEnds) {
  std::vector<Pose> poses;
  for (int i = 0; i < 3000; ++i) {
    const double azimuth = 20.0 + 0.05 * i + (i / 700 % 2 == 0 ? 0.0 : 160.0);
    poses.push_back({{30 + 0.01 * i, 0.02 * (i % 40), 5}, axis_at(30 + 5 * std::sin(0.01 * i), azimuth)});
  }
  JointPath joints;
  expect_good(poses, trunnion(), &joints);
  bool positive = false, negative = false;  // heads of the fine moves
  for (const JointMove& move : joints.moves) {
    if (move.move % 700 == 0) continue;
    positive = positive || move.joints.a > 0;
    negative = negative || move.joints.a < 0;
  }
  EXPECT_NE(positive, negative) << "the path was to keep its branch";
}

/// Random poses, a third of them near the pole, on machines with every sign, zero and head.
TEST(JointPole, RandomPathsOnRandomMachines) {
  const double half = std::sqrt(0.5);
  const Vec3 heads[]{{1, 0, 0}, {0, 1, 0}, {-0.6, 0.8, 0}, {0, half, half}};
  for (unsigned seed = 1; seed <= unsigned{samples(160)}; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> mm(-80, 80), degrees(-180, 180), unit(0, 1);
    MachineModel m = trunnion(heads[seed % 4]);
    m.tilt.sign = unit(random) < 0.5 ? -1 : 1;
    m.rotary.sign = unit(random) < 0.5 ? -1 : 1;
    m.tilt.zero = 10 * unit(random);
    m.rotary.zero = degrees(random);
    m.tilt.min = m.tilt.zero - 181;
    m.tilt.max = m.tilt.zero + 181;
    // Every fourth machine has a head that ends at the pole, on one side or the other.
    if (seed % 4 == 1 && unit(random) < 0.5) m.tilt.min = m.tilt.zero;
    if (seed % 4 == 2 && unit(random) < 0.5) m.tilt.max = m.tilt.zero;
    tiltfeed::Setup setup = standing();
    setup.fixture = rotation_about(axis_at(degrees(random), degrees(random)), 0.4 * unit(random));
    std::vector<Pose> poses;
    for (int i = 0; i < 12; ++i) {
      const double tilt = unit(random) < 0.33 ? std::pow(10.0, -6 + 7 * unit(random)) : 85 * unit(random);
      poses.push_back({{mm(random), mm(random), mm(random)},
                       normalized(transposed(setup.fixture) * axis_at(tilt, degrees(random)))});
    }
    const ToolPath path = path_of(poses, seed % 3 == 0 ? MoveKind::kRapid : MoveKind::kCut);
    const auto joints = to_joints(path, m, setup, {});
    ASSERT_TRUE(joints) << joints.error().message;
    check_densely(path, m, setup, {}, *joints);
    ASSERT_FALSE(HasFailure());
  }
}

}  // namespace
}  // namespace tiltfeed
