// Lower bounds of a program's time: closed forms, and never more than the time itself.

#include "kinematics/timing/lower_bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinematics/joints/joint_path.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed {
namespace {

MachineModel mill() {
  MachineModel m;
  m.x = m.y = m.z = {-2000, 2000, 12000, 2000};
  m.tilt = {'A', {1, 0, 0}, +1, 0.0, -120, 120, 3600, 600};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -1e6, 1e6, 7200, 1200};
  m.pivot_to_gauge = {0, 0, -150};
  return m;
}

TEST(LowerBounds, AreThoseOfAStraightCut) {
  ToolPath path;
  path.cut_feed = Feed::from_mm_per_min(1200), path.plunge_feed = Feed::from_mm_per_min(300);
  const Vec3 up{0, 0, 1};
  path.moves = {{{{0, 0, 50}, up}, MoveKind::kRapid, 0},
                {{{0, 0, 10}, up}, MoveKind::kRapid, 0},
                {{{0, 0, 0}, up}, MoveKind::kPlunge, 0},
                {{{30, 40, 0}, up}, MoveKind::kCut, 0}};
  std::vector<JointMove> moves;
  for (const Move& move : path.moves)
    moves.push_back({{move.pose.tip.x, move.pose.tip.y, move.pose.tip.z, 0, 0}, 0.0, move.kind, 0});
  moves[1].seconds = 0.2, moves[2].seconds = 2.0, moves[3].seconds = 2.5;
  const LowerBounds bounds = lower_bounds(path, moves, mill());
  EXPECT_NEAR(bounds.path, 10.0 / 300 * 60 + 50.0 / 1200 * 60, 1e-12);
  EXPECT_NEAR(bounds.axes.x, 30.0 / 12000 * 60, 1e-12);
  EXPECT_NEAR(bounds.axes.y, 40.0 / 12000 * 60, 1e-12);
  EXPECT_NEAR(bounds.axes.z, 50.0 / 12000 * 60, 1e-12);
  EXPECT_EQ(bounds.axes.a, 0.0);
  EXPECT_NEAR(bounds.blocks, 4.7, 1e-12);
  EXPECT_EQ(bounds.most(), bounds.blocks);
  LowerBounds twice = bounds;
  twice.add(bounds);
  EXPECT_NEAR(twice.path, 2 * bounds.path, 1e-12);
  EXPECT_NEAR(twice.axes.z, 2 * bounds.axes.z, 1e-12);
  EXPECT_NEAR(twice.blocks, 2 * bounds.blocks, 1e-12);
}

/// Random paths whose axis turns: the joints are found by the solver, their times by the planner of corners.
TEST(LowerBounds, P1P2NoTimeIsLess) {
  std::mt19937_64 random(5);
  const auto some = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int round = 0; round < 60; ++round) {
    ToolPath path;
    path.cut_feed = Feed::from_mm_per_min(some(200, 20000)), path.plunge_feed = Feed::from_mm_per_min(400);
    Vec3 axis{some(-0.5, 0.5), some(-0.5, 0.5), 1.0};
    Point<Part> tip{some(-50, 50), some(-50, 50), 20};
    path.moves = {{{tip, normalized(axis)}, MoveKind::kRapid, 0}};
    for (int i = 0; i < 40; ++i) {
      axis = axis + Vec3{some(-0.1, 0.1), some(-0.1, 0.1), 0.0};
      tip = tip + Vec3{some(-5, 5), some(-5, 5), some(-1, 1)};
      const MoveKind kind = i == 0 ? MoveKind::kPlunge : i % 9 == 8 ? MoveKind::kRapid : MoveKind::kCut;
      path.moves.push_back({{tip, normalized(axis)}, kind, 0});
    }
    tiltfeed::Setup setup;
    setup.part_zero = {0, 0, 100};
    setup.tool_length = 100;
    JointPathOptions options;
    options.tolerance = 0.005;
    const auto joints = to_joints(path, mill(), setup, options);
    ASSERT_TRUE(joints) << joints.error().message;
    const Timing timing = time_blocks(joints->moves, mill(), 0.005, 0.05);
    const LowerBounds bounds = lower_bounds(path, joints->moves, mill());
    const double blocks = bounds.blocks * (1.0 + 1e-6);
    EXPECT_NEAR(bounds.blocks, joints->report.seconds, 1e-6 * bounds.blocks);
    for (const double one :
         {bounds.path, bounds.axes.x, bounds.axes.y, bounds.axes.z, bounds.axes.a, bounds.axes.c})
      EXPECT_LE(one, blocks) << round;
    EXPECT_LE(bounds.most(), timing.seconds * (1.0 + 1e-6));
    EXPECT_GT(bounds.path, 0.0);
  }
}

}  // namespace
}  // namespace tiltfeed
