// Where a program's minutes go: closed forms of a path that has each kind of motion.

#include "kinematics/timing/time_by_motion.h"

#include <gtest/gtest.h>

#include <numeric>

#include "kinematics/joints/joint_path.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed {
namespace {

MachineModel shop_mill() {
  MachineModel m;
  m.x = m.y = m.z = {-2000, 2000, 12000, 2000};  // 200 mm/s
  m.tilt = {'A', {1, 0, 0}, +1, 0.0, -120, 120, 3600, 600};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -1e6, 1e6, 7200, 1200};
  m.pivot_to_gauge = {0, 0, -150};
  return m;
}

double sum(const TimeByMotion& t) {
  return t.cuts_at_feed + t.slow_axes + t.accelerations + t.plunges + t.rapids + t.swings;
}

/// With the tool upright X Y Z are the tip's, and a turn of the table under a tip in its middle is C alone.
TEST(TimeByMotion, IsThatOfEachKind) {
  ToolPath path;
  path.cut_feed = Feed::from_mm_per_min(1200), path.plunge_feed = Feed::from_mm_per_min(300);
  const Vec3 up{0, 0, 1};
  path.moves = {{{{0, 0, 50}, up}, MoveKind::kRapid, 0},   {{{100, 0, 50}, up}, MoveKind::kRapid, 0},
                {{{100, 0, 50}, up}, MoveKind::kRapid, 0}, {{{100, 0, 40}, up}, MoveKind::kPlunge, 0},
                {{{140, 30, 40}, up}, MoveKind::kCut, 0},  {{{150, 30, 40}, up}, MoveKind::kCut, 0}};
  const std::vector<Joints> at{{0, 0, 50, 0, 0},    {100, 0, 50, 0, 0},   {100, 0, 50, 0, 90},
                               {100, 0, 40, 0, 90}, {140, 30, 40, 0, 90}, {150, 30, 40, 0, 450}};
  const double programmed[] = {0.0, 0.5, 0.75, 2.0, 2.5, 3.0};  // the last one waits for 360 degrees of C
  std::vector<JointMove> moves;
  for (std::size_t i = 0; i < at.size(); ++i) moves.push_back({at[i], programmed[i], path.moves[i].kind, 0});
  const std::vector<double> durations{0.0, 0.6, 0.9, 2.1, 2.75, 3.5};
  TimeByMotion t = time_by_motion(path, moves, durations, shop_mill());
  EXPECT_NEAR(t.rapids, 0.6, 1e-12);
  EXPECT_NEAR(t.swings, 0.9, 1e-12);
  EXPECT_NEAR(t.plunges, 2.1, 1e-12);
  EXPECT_NEAR(t.cuts_at_feed, 60.0 / 20.0, 1e-12);
  EXPECT_NEAR(t.slow_axes, 3.0 - 10.0 / 20.0, 1e-12);
  EXPECT_NEAR(t.accelerations, 0.25 + 0.5, 1e-12);
  t.add(t);
  EXPECT_NEAR(sum(t), 2 * 9.85, 1e-12);
}

/// A circle about the table's axis that the tool cuts lying: the table has to turn faster than it can.
TEST(TimeByMotion, AddsUpToTheTimeOfAPath) {
  ToolPath path;
  path.cut_feed = Feed::from_mm_per_min(6000), path.plunge_feed = Feed::from_mm_per_min(400);
  path.tool = {6, 3, 80};
  const auto pose = [](double degrees, double radius) {
    const double a = degrees * kPi / 180.0;
    const Vec3 out{std::cos(a), std::sin(a), 0.0};
    return Pose{Point<Part>{} + out * radius, out};
  };
  path.moves.push_back({pose(0, 60), MoveKind::kRapid, 0});
  path.moves.push_back({pose(0, 40), MoveKind::kRapid, 0});
  path.moves.push_back({pose(0, 20), MoveKind::kPlunge, 0});
  for (double degrees = 1; degrees <= 360; ++degrees)
    path.moves.push_back({pose(degrees, 20), MoveKind::kCut, 0});
  const MachineModel machine = shop_mill();
  const auto joints = to_joints(path, machine, {.part_zero = {0, 0, 100}, .tool_length = 80}, {});
  ASSERT_TRUE(joints) << joints.error().message;
  const Timing timing = time_blocks(joints->moves, machine, 0.01, 0.05);
  const TimeByMotion t = time_by_motion(path, joints->moves, timing.durations, machine);
  EXPECT_NEAR(sum(t), timing.seconds, 1e-9 * timing.seconds);
  EXPECT_NEAR(t.cuts_at_feed, 2 * kPi * 20 / 100.0, 1e-3) << "of a polygon of 360 sides";
  // A turn at 120 degrees/s takes 3 s.
  EXPECT_NEAR(t.cuts_at_feed + t.slow_axes, 3.0, 0.01);
  EXPECT_GT(t.accelerations, 0.0);
  EXPECT_EQ(t.swings, 0.0);
}

}  // namespace
}  // namespace tiltfeed
