// Calm axes against a plain descent, and held to their properties; what they are for: the machine is quicker.

#include "kinematics/joints/calm_axes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "kinematics/joints/even_turn.h"
#include "kinematics/timing/control_timing.h"
#include "tests/judges/joint_path_check.h"

namespace tiltfeed {
namespace {

using namespace joint_check;

constexpr double kCalmBall = 3.0;  // radius of path_of's tool

/// At 90 degrees of tilt a cone is an interval of turns. Plain steps down the gradient, each cut off at the
/// intervals, until nothing moves.
double least_cost(const std::vector<TurnNode>& nodes) {
  std::vector<double> x;
  for (const TurnNode& node : nodes) x.push_back(node.axis.turn);
  for (int k = 0; k < 200'000; ++k) {
    double moved = 0.0;
    for (std::size_t i = 1; i + 1 < x.size(); ++i) {
      const double before = 1.0 / (nodes[i].seconds - nodes[i - 1].seconds),
                   behind = 1.0 / (nodes[i + 1].seconds - nodes[i].seconds);
      const double slope = (x[i] - x[i - 1]) * before - (x[i + 1] - x[i]) * behind;
      const double next = std::clamp(x[i] - 0.5 * slope / (before + behind),
                                     nodes[i].axis.turn - nodes[i].cone, nodes[i].axis.turn + nodes[i].cone);
      moved = std::max(moved, std::abs(next - x[i]));
      x[i] = next;
    }
    if (moved < 1e-12) break;
  }
  double sum = 0.0;
  for (std::size_t i = 1; i < x.size(); ++i)
    sum += (x[i] - x[i - 1]) * (x[i] - x[i - 1]) / (nodes[i].seconds - nodes[i - 1].seconds);
  return sum;
}

std::vector<TurnNode> random_turns(std::mt19937& random, std::size_t count, bool across) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<TurnNode> nodes;
  double turn = 0.0, seconds = 0.0, rate = 0.0, tilt = kPi / 2.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (unit(random) < 0.15) rate = 4.0 * (unit(random) - 0.5);
    const double step = 0.005 + 0.03 * unit(random);
    seconds += step, turn += rate * step;
    if (across) tilt = std::clamp(tilt + 0.1 * (unit(random) - 0.5), 0.5, 2.6);
    nodes.push_back({{tilt, turn}, seconds, 0.02 + 0.06 * unit(random)});
  }
  nodes.front().cone = nodes.back().cone = 0.0;
  if (count > 8) nodes[count / 2].cone = 0.0;
  return nodes;
}

TEST(EvenTurn, CostsAsLittleAsAPlainDescentFinds) {
  std::mt19937 random(5);
  for (int run = 0; run < 60; ++run) {
    const auto nodes = random_turns(random, 3 + static_cast<std::size_t>(run) * 2, false);
    const auto axes = even_turn(nodes, {});
    const double least = least_cost(nodes), cost = turn_cost(nodes, axes);
    std::vector<AxisAngles> planned;
    for (const TurnNode& node : nodes) planned.push_back(node.axis);
    EXPECT_LE(cost, least * 1.02 + 1e-9) << run;
    EXPECT_GE(cost, least * (1.0 - 1e-6) - 1e-9) << run;
    EXPECT_LE(cost, turn_cost(nodes, planned)) << run;
  }
}

TEST(EvenTurn, KeepsToItsConesByTheAnglesOfVectors) {
  std::mt19937 random(6);
  const auto vector = [](const AxisAngles& a) {
    return Vec3{std::sin(a.tilt) * std::cos(a.turn), std::sin(a.tilt) * std::sin(a.turn), std::cos(a.tilt)};
  };
  for (int run = 0; run < 40; ++run) {
    const auto nodes = random_turns(random, 80, true);
    const auto axes = even_turn(nodes, {});
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const double lean = angle_between(vector(axes[i]), vector(nodes[i].axis));
      EXPECT_NEAR(lean, angle_between(axes[i], nodes[i].axis), 1e-7);
      EXPECT_LE(lean, nodes[i].cone + 1e-7);
    }
    EXPECT_EQ(axes.front(), nodes.front().axis);
    EXPECT_EQ(axes[40], nodes[40].axis);
  }
}

/// A tip that goes along evenly while the axis swings to and fro and stands now and then.
ToolPath swinging(int count, double swing_deg, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Pose> poses;
  double tilt = 50.0, azimuth = 0.0, rate = 0.0;
  Point<Part> centre{0, 5, 0};
  for (int i = 0; i <= count; ++i) {
    if (i % 12 == 0) rate = (i / 12) % 3 == 2 ? 0.0 : swing_deg * unit(random);
    azimuth += rate, tilt += 0.3 * rate * unit(random), centre.x += 0.3;
    const Vec3 axis = axis_at(std::clamp(tilt, 20.0, 80.0), azimuth);
    poses.push_back({centre - axis * kCalmBall, axis});
  }
  return path_of(poses);
}

double machine_seconds(const ToolPath& path) {
  JointPathOptions options;
  options.tolerance = 0.002;
  const MachineModel m = trunnion();
  const auto joints = to_joints(path, m, standing(), options);
  EXPECT_TRUE(joints) << joints.error().message;
  return joints ? time_on_control(joints->moves, m, {}).seconds : 0.0;
}

Point<Part> centre_of(const Pose& pose) { return pose.tip + pose.axis * kCalmBall; }

constexpr double kNoLean = 1e-6;

/// How far each axis of `calm` leans from the plan's where the ball is there, rad. Expects its centre on the
/// way of the plan, point by point: it rises in x.
std::vector<double> leans_of(const ToolPath& path, const ToolPath& calm) {
  std::vector<double> leans;
  std::size_t at = 0;
  for (const Move& move : calm.moves) {
    while (at + 1 < path.moves.size() && centre_of(path.moves[at].pose).x < centre_of(move.pose).x - 1e-9)
      ++at;
    const Pose &a = path.moves[at > 0 ? at - 1 : 0].pose, &b = path.moves[at].pose;
    const double whole = centre_of(b).x - centre_of(a).x;
    const double f = whole > 0.0 ? (centre_of(move.pose).x - centre_of(a).x) / whole : 1.0;
    EXPECT_LE(distance(centre_of(move.pose), centre_of(a) + (centre_of(b) - centre_of(a)) * f), 1e-9);
    leans.push_back(angle_between(move.pose.axis, slerp(a.axis, b.axis, f)));
  }
  return leans;
}

TEST(CalmAxes, KeepTheBallAndTheConeAndOnlyGoWhereTheToolIsClear) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const ToolPath path = swinging(600, 1.5, seed);
    std::mutex asked;
    std::vector<std::pair<Pose, Pose>> accepted;
    // Between x 60 and 90 nothing but the planned axis is clear.
    const auto kept = [](const Pose& pose) { return centre_of(pose).x > 60.0 && centre_of(pose).x < 90.0; };
    const MoveCheck clear = [&](const Pose& from, const Pose& to) {
      if (kept(from) || kept(to)) return false;
      const std::lock_guard lock(asked);
      accepted.emplace_back(from, to);
      return true;
    };
    const CalmPath calm = *calm_axes(path, {0, 0, 1}, {Angle::from_degrees(4.0), 0.001}, clear);
    EXPECT_GT(calm.report.points, 200u);
    EXPECT_GT(calm.report.refused, 0u);
    EXPECT_EQ(calm.path.moves.front().pose, path.moves.front().pose);
    EXPECT_EQ(calm.path.moves.back().pose, path.moves.back().pose);
    const std::vector<double> leans = leans_of(path, calm.path);
    for (std::size_t i = 0; i < leans.size(); ++i)
      if (kept(calm.path.moves[i].pose)) {
        EXPECT_LE(leans[i], kNoLean);
      }
    const double largest = *std::max_element(leans.begin(), leans.end());
    EXPECT_LE(Angle::from_radians(largest).degrees(), 4.0 + 1e-6);
    EXPECT_NEAR(Angle::from_radians(largest).degrees(), calm.report.largest.degrees(), 1e-6);
    for (std::size_t i = 1; i < calm.path.moves.size(); ++i) {
      if (leans[i] <= kNoLean && leans[i - 1] <= kNoLean) continue;
      const std::pair<Pose, Pose> move{calm.path.moves[i - 1].pose, calm.path.moves[i].pose};
      EXPECT_TRUE(std::any_of(accepted.begin(), accepted.end(), [&](const auto& one) {
        return distance(one.first.tip, move.first.tip) < 1e-9 &&
               distance(one.second.tip, move.second.tip) < 1e-9;
      })) << i;
    }
  }
}

/// An axis that comes near to the table's and goes far from it, several times a second, and turns unevenly.
ToolPath swooping(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Pose> poses;
  double azimuth = 0.0, rate = 0.0;
  Point<Part> centre{0, 5, 0};
  for (int i = 0; i <= count; ++i) {
    if (i % 12 == 0) rate = 4.0 * unit(random);
    azimuth += rate, centre.x += 0.02;
    const Vec3 axis = axis_at(47.0 + 35.0 * std::sin(0.09 * i), azimuth);
    poses.push_back({centre - axis * kCalmBall, axis});
  }
  ToolPath path = path_of(poses);
  path.cut_feed = Feed::from_mm_per_min(10'000.0);
  return path;
}

/// Where the tilt changes much from node to node the even way between two axes in their cones leaves the cone
/// about the planned one.
TEST(CalmAxes, KeepToTheConeBetweenTheirNodes) {
  const MoveCheck anything = [](const Pose&, const Pose&) { return true; };
  std::size_t points = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ToolPath path = swooping(600, seed);
    const CalmPath calm = *calm_axes(path, {0, 0, 1}, {Angle::from_degrees(5.0), 0.1}, anything);
    const std::vector<double> leans = leans_of(path, calm.path);
    const double largest = *std::max_element(leans.begin(), leans.end());
    EXPECT_LE(Angle::from_radians(largest).degrees(), 5.0 + 1e-6) << seed;
    points += calm.report.points;
  }
  EXPECT_GT(points, 2000u);
}

TEST(CalmAxes, SayHowFarTheyAreAndEndWhenTheyAreTold) {
  std::atomic<int> checked{0};
  const MoveCheck counted = [&](const Pose&, const Pose&) { return ++checked, true; };
  const ToolPath path = swinging(6000, 1.5, 3);
  const CalmOptions options{Angle::from_degrees(4.0), 0.001};
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);  // all checks are its own
  const std::thread::id own = std::this_thread::get_id();
  std::vector<double> told;
  const auto calm = calm_axes(path, {0, 0, 1}, options, counted, [&](double share) {
    EXPECT_EQ(std::this_thread::get_id(), own);
    told.push_back(share);
    return true;
  });
  ASSERT_TRUE(calm) << calm.error().message;
  EXPECT_GT(told.size(), 4u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.front(), 0.0);
  EXPECT_EQ(told.back(), 1.0) << "each cutting move was checked";
  const int all = checked.exchange(0);
  const auto ended = calm_axes(path, {0, 0, 1}, options, counted, [](double share) { return share == 0.0; });
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, Code::kCancelled);
  EXPECT_LT(checked, all) << "it went on to its end";
  const auto silent = calm_axes(path, {0, 0, 1}, options, counted);
  ASSERT_TRUE(silent);
  EXPECT_EQ(silent->report.points, calm->report.points);
}

TEST(CalmAxes, TheMachineIsQuicker) {
  const MoveCheck anything = [](const Pose&, const Pose&) { return true; };
  const ToolPath path = swinging(600, 1.5, 9);
  const double planned = machine_seconds(path);
  double before = planned;
  for (const double cone : {1.0, 3.0, 8.0}) {
    const double now =
        machine_seconds(calm_axes(path, {0, 0, 1}, {Angle::from_degrees(cone), 0.001}, anything)->path);
    EXPECT_LT(now, before) << cone;
    before = now;
  }
  EXPECT_LT(before, 0.8 * planned);
}

}  // namespace
}  // namespace tiltfeed
