// Bending near the pole against closed forms and exhaustive search, and what it is for: the rotary's speed.

#include "kinematics/joints/singularity_bend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "kinematics/joints/axis_shift_search.h"
#include "tests/judges/joint_path_check.h"

namespace tiltfeed {
namespace {

using namespace joint_check;

const MoveCheck kAnything = [](const Pose&, const Pose&) { return true; };
constexpr double kBall = 3.0;  // radius of path_of's tool

/// A great circle of axes whose nearest approach to the pole is `distance_deg`, the tip going along, `count`
/// moves.
ToolPath past_the_pole(double distance_deg, int count, double tilt_deg = 40.0) {
  const double d = Angle::from_degrees(distance_deg).radians(), t = Angle::from_degrees(tilt_deg).radians();
  const Vec3 nearest{0, std::sin(d), std::cos(d)}, along{1, 0, 0};
  std::vector<Pose> poses;
  for (int i = 0; i <= count; ++i) {
    const double s = t * (2.0 * i / count - 1.0);
    poses.push_back({{60.0 * i / count, 5, 0}, normalized(nearest * std::cos(s) + along * std::sin(s))});
  }
  return path_of(poses);
}

SingularityBendOptions within(double degrees) { return {Angle::from_degrees(degrees), 0.001}; }

/// The largest share of the rotary's speed that the path would take at its programmed feed.
double largest_share(const ToolPath& path, const MachineModel& m) {
  JointPathOptions options;
  options.tolerance = 0.002;
  options.axis_tolerance = 0.01;
  const auto joints = to_joints(path, m, standing(), options);
  EXPECT_TRUE(joints) << joints.error().message;
  double worst = 0.0;
  if (!joints) return worst;
  // The tip's own way: what the feed would take for each block.
  for (std::size_t i = 1; i < joints->moves.size(); ++i) {
    const Joints &p = joints->moves[i - 1].joints, &q = joints->moves[i].joints;
    const double way = distance(forward(m, standing(), p).tip, forward(m, standing(), q).tip);
    const double minutes = way / path.cut_feed.mm_per_min();
    if (minutes > 1e-6) worst = std::max(worst, std::abs(q.c - p.c) / m.rotary.velocity / minutes);
  }
  return worst;
}

/// Every point of `bent` leans by at most `most` from the nearest place of the planned path, with the ball's
/// centre there.
void expect_near(const ToolPath& planned, const ToolPath& bent, double most_deg) {
  for (std::size_t i = 0; i < bent.moves.size(); ++i) {
    const Pose& pose = bent.moves[i].pose;
    const Point<Part> centre = pose.tip + pose.axis * kBall;
    double lean = 180.0;
    for (std::size_t k = 1; k < planned.moves.size(); ++k) {
      const Pose &a = planned.moves[k - 1].pose, &b = planned.moves[k].pose;
      const double reach = distance(a.tip, b.tip) + 4 * kBall;
      if (distance(a.tip, pose.tip) > reach) continue;
      // The place where the centre would be: by bisection of the distance along the move.
      double low = 0.0, high = 1.0;
      const auto at = [&](double f) {
        const Vec3 axis = slerp(a.axis, b.axis, f);
        return Pose{lerp(a.tip, b.tip, f), axis};
      };
      const auto off = [&](double f) { return distance(at(f).tip + at(f).axis * kBall, centre); };
      for (int round = 0; round < 80; ++round) {
        const double f = low + (high - low) / 3, g = high - (high - low) / 3;
        (off(f) < off(g) ? high : low) = off(f) < off(g) ? g : f;
      }
      if (off(low) < 1e-6)
        lean = std::min(lean, Angle::from_radians(angle_between(at(low).axis, pose.axis)).degrees());
    }
    ASSERT_LE(lean, most_deg * (1 + 1e-9)) << "point " << i;
  }
}

TEST(SingularityBend, PassesThroughAPoleThatIsWithinTheTolerance) {
  const MachineModel m = trunnion();
  for (const int moves : {1, 7, 100}) {
    for (const double distance : {0.2, 0.5, 1.0}) {
      SCOPED_TRACE(testing::Message() << moves << " moves, " << distance << " degrees off");
      const ToolPath path = past_the_pole(distance, moves);
      const SingularityBend bent = bend_at_singularity(path, m, standing(), within(1.0), kAnything);
      EXPECT_EQ(bent.report.stretches, 1u);
      EXPECT_GE(bent.report.largest.degrees(), distance * 0.999) << "the pole is so far off";
      expect_near(path, bent.path, 1.0);
      // As it would be exactly, the rotary turns at F kappa / sin(distance); bent it hardly turns.
      const double exact = largest_share(path, m), now = largest_share(bent.path, m);
      EXPECT_LT(now, 0.25 * exact);
      const auto joints = to_joints(bent.path, m, standing(), {});
      ASSERT_TRUE(joints) << joints.error().message;
      check_densely(bent.path, m, standing(), {}, *joints);
    }
  }
}

TEST(SingularityBend, GoesRoundAPoleThatIsFurtherOff) {
  const MachineModel m = trunnion();
  const ToolPath path = past_the_pole(2.0, 60);
  const SingularityBend bent = bend_at_singularity(path, m, standing(), within(1.0), kAnything);
  EXPECT_EQ(bent.report.stretches, 1u);
  expect_near(path, bent.path, 1.0);
  // F kappa / sin: at 3 degrees instead of 2 the rotary has two thirds of its speed; the way round is longer.
  EXPECT_NEAR(largest_share(bent.path, m) / largest_share(path, m),
              std::sin(2.0 * kPi / 180) / std::sin(3.0 * kPi / 180), 0.06);
}

TEST(SingularityBend, AHeadThatEndsAtThePoleGoesRoundIt) {
  MachineModel m = trunnion();
  m.tilt.min = 0.0;
  const ToolPath path = past_the_pole(0.5, 60);
  const SingularityBend bent = bend_at_singularity(path, m, standing(), within(2.0), kAnything);
  EXPECT_EQ(bent.report.stretches, 1u);
  expect_near(path, bent.path, 2.0);
  double nearest = 180.0;
  for (const Move& move : bent.path.moves)
    nearest = std::min(nearest, Angle::from_radians(angle_between(move.pose.axis, {0, 0, 1})).degrees());
  EXPECT_NEAR(nearest, 2.5, 0.1);
}

TEST(SingularityBend, WhatDoesNotMatterStaysAsItIs) {
  const MachineModel m = trunnion();
  ToolPath far = past_the_pole(30.0, 20);
  EXPECT_EQ(bend_at_singularity(far, m, standing(), within(1.0), kAnything).path.moves.size(),
            far.moves.size());
  // So slow that the rotary follows at leisure.
  ToolPath slow = past_the_pole(1.0, 20);
  slow.cut_feed = Feed::from_mm_per_min(2);
  const SingularityBend same = bend_at_singularity(slow, m, standing(), within(1.0), kAnything);
  EXPECT_EQ(same.report.stretches, 0u);
  ASSERT_EQ(same.path.moves.size(), slow.moves.size());
  for (std::size_t i = 0; i < slow.moves.size(); ++i) EXPECT_EQ(same.path.moves[i].pose, slow.moves[i].pose);
  // Rapids are not bent.
  ToolPath rapid = past_the_pole(0.5, 20);
  for (Move& move : rapid.moves) move.kind = MoveKind::kRapid;
  EXPECT_EQ(bend_at_singularity(rapid, m, standing(), within(1.0), kAnything).report.stretches, 0u);
  // The ends of a pass are kept, whatever is in its middle.
  const ToolPath path = past_the_pole(0.5, 20);
  const SingularityBend bent = bend_at_singularity(path, m, standing(), within(1.0), kAnything);
  EXPECT_EQ(bent.path.moves.front().pose, path.moves.front().pose);
  EXPECT_EQ(bent.path.moves.back().pose, path.moves.back().pose);
}

/// A wall that the shank may not lean into: what leans is asked for, and the answer obeyed.
TEST(SingularityBend, LeansOnlyWhereTheToolIsClear) {
  const MachineModel m = trunnion();
  const ToolPath path = past_the_pole(0.8, 120);
  for (const double wall_deg : {-0.1, 0.0, 0.3, 0.6}) {
    SCOPED_TRACE(wall_deg);
    // The planned axes lie on this side of the pole: leaning over means less y than the wall allows.
    const double least = std::sin(Angle::from_degrees(wall_deg).radians());
    const MoveCheck wall = [&](const Pose& a, const Pose& b) {
      for (const double f : {0.0, 0.25, 0.5, 0.75, 1.0})
        if (slerp(a.axis, b.axis, f).y < least * std::min(1.0, slerp(a.axis, b.axis, f).z)) return false;
      return true;
    };
    const SingularityBend bent = bend_at_singularity(path, m, standing(), within(1.0), wall);
    std::size_t leaning = 0;
    for (std::size_t i = 1; i < bent.path.moves.size(); ++i) {
      const auto planned = [&](const Pose& pose) {
        return std::abs(angle_between(pose.axis, {0, -std::cos(0.8 * kPi / 180), std::sin(0.8 * kPi / 180)}) -
                        kPi / 2) < 1e-9;
      };
      const Pose &a = bent.path.moves[i - 1].pose, &b = bent.path.moves[i].pose;
      if (planned(a) && planned(b)) continue;
      ++leaning;
      EXPECT_TRUE(wall(a, b)) << "move " << i;
    }
    EXPECT_GT(leaning, 0u) << "the other side is free";
  }
  const SingularityBend none =
      bend_at_singularity(path, m, standing(), within(1.0), [](const Pose&, const Pose&) { return false; });
  EXPECT_EQ(none.report.stretches, 0u);
  EXPECT_EQ(none.report.refused, 1u);
  ASSERT_EQ(none.path.moves.size(), path.moves.size());
}

/// Feeds of the path keep their moves.
TEST(SingularityBend, FeedsKeepTheirPlace) {
  const MachineModel m = trunnion();
  ToolPath path = past_the_pole(0.5, 40);
  path.feeds = {
      {1, Feed::from_mm_per_min(1000)}, {13, Feed::from_mm_per_min(900)}, {33, Feed::from_mm_per_min(800)}};
  const SingularityBend bent = bend_at_singularity(path, m, standing(), within(1.0), kAnything);
  ASSERT_GT(bent.path.moves.size(), path.moves.size());
  for (std::size_t k = 1; k < 3; ++k) {
    // The move before the change ends at the centre where it ended before.
    const Pose &there = path.moves[path.feeds[k].move - 1].pose,
               &here = bent.path.moves[bent.path.feeds[k].move - 1].pose;
    EXPECT_NEAR(distance(there.tip + there.axis * kBall, here.tip + here.axis * kBall), 0.0, 1e-9);
  }
}

/// The least sum over every choice of shifts that the slope allows, one after the other.
double exhaustive(const AxisShiftSearch& choice, const std::vector<ShiftNode>& nodes,
                  std::vector<Vec3>& shifts, std::size_t at) {
  if (at + 1 == nodes.size())
    return choice.cost(nodes, shifts).value_or(std::numeric_limits<double>::infinity());
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3 shift : choice.shifts_of(nodes[at])) {
    if (length(shift - shifts[at - 1]) > kBendSlope * (nodes[at].turned - nodes[at - 1].turned) * (1 + 1e-9))
      continue;
    shifts[at] = shift;
    least = std::min(least, exhaustive(choice, nodes, shifts, at + 1));
  }
  shifts[at] = {};
  return least;
}

TEST(SingularityBend, IsTheBestOfAllThatThereAre) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Vec3 heads[]{{1, 0, 0}, {0, 1, 0}, {0, std::sqrt(0.5), std::sqrt(0.5)}};
  int bent = 0;
  for (int round = 0; round < 30; ++round) {
    MachineModel m = trunnion(heads[round % 3]);
    if (round % 4 == 3) m.tilt.min = 0.0;
    const double most = Angle::from_degrees(2.0).radians();
    const Vec3 pole{0, 0, 1};
    const JointChooser chooser(m, standing(), 9, 9, 0.0);
    const AxisShiftSearch choice(m, chooser, pole, most);
    // Five nodes on a way past the pole, a little crooked.
    std::vector<ShiftNode> nodes;
    const double off = 1.5 * most * unit(random);
    for (int k = 0; k < 5; ++k) {
      const double s = 0.35 * most * (k - 2);
      const Vec3 axis = normalized(Vec3{s, off + 0.05 * most * unit(random), 1.0});
      ShiftNode node{{{10.0 * k, 0, 0}, axis}, {}, 0.0, 0.01 * k, -most, most};
      node.ahead = normalized(Vec3{1, 0, 0} - axis * axis.x);
      node.turned = 0.35 * most * k;
      nodes.push_back(node);
    }
    const auto best = choice.best(nodes);
    ASSERT_TRUE(best);
    std::vector<Vec3> shifts(nodes.size());
    const double least = exhaustive(choice, nodes, shifts, 1);
    ASSERT_NEAR(*choice.cost(nodes, *best), least, 1e-9 * least) << "round " << round;
    for (const Vec3 shift : *best) bent += length(shift) > 0 ? 1 : 0;
  }
  EXPECT_GT(bent, 30);
}

}  // namespace
}  // namespace tiltfeed
