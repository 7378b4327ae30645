// Joints of whole operations: cones in closed form within limits of all kinds, the table turned back with the
// tool off the part, the fewest times, in the air where that serves.

#include "kinematics/joints/operation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "tests/judges/joint_path_check.h"

namespace tiltfeed {
namespace {

using namespace joint_check;

constexpr double kClear = 100.0;  // mm above part zero: all parts here are lower

JointPathOptions with_detours() {
  JointPathOptions options;
  options.clear.height = kClear;
  return options;
}

Vec3 rotated(Vec3 v, Vec3 about, double radians) { return normalized(rotation_about(about, radians) * v); }

/// Once round the flank of a cone of half-apex `apex`, its axis inclined by `inclined` degrees.
std::vector<Pose> cone(double apex, double inclined) {
  const Vec3 axis = axis_at(inclined, 0), flank = axis_at(inclined + apex, 0);
  return sampled(720, [&](double f) {
    const Vec3 u = rotated(flank, axis, 0.3 + 2 * kPi * f);
    return Pose{Point<Part>{} + u * 30.0, u};
  });
}

/// The moves of `longer` that are not of `path`; expects all of `path`'s in their order.
std::vector<Move> put_in(const ToolPath& path, const ToolPath& longer) {
  std::vector<Move> extra;
  std::size_t next = 0;
  for (const Move& move : longer.moves) {
    const bool own =
        next < path.moves.size() && move.pose == path.moves[next].pose && move.kind == path.moves[next].kind;
    if (own)
      ++next;
    else
      extra.push_back(move);
  }
  EXPECT_EQ(next, path.moves.size());
  return extra;
}

/// Walks the path, holds it to every tolerance and limit, and the detours to what is safe.
JointPath expect_led_through(const ToolPath& path, const MachineModel& m, std::uint64_t changes) {
  const auto joints = to_joints(path, m, standing(), with_detours());
  if (!joints) {
    ADD_FAILURE() << joints.error().message;
    return {};
  }
  EXPECT_EQ(joints->report.reconfigurations, changes);
  EXPECT_EQ(joints->reconfigured.has_value(), changes > 0);
  const ToolPath& walked = joints->reconfigured ? *joints->reconfigured : path;
  check_densely(walked, m, standing(), with_detours(), *joints);
  const std::vector<Move> extra = put_in(path, walked);
  for (std::size_t i = 0; i < extra.size(); ++i) {
    const bool set_down = extra[i].kind != MoveKind::kRapid;
    EXPECT_NE(extra[i].kind, MoveKind::kCut);
    // Only along the tool axis below the clear height: off and on keep the axis of the place.
    if (extra[i].pose.tip.z < kClear - 1e-9 && i > 0) {
      EXPECT_LT(angle_between(extra[i].pose.axis, extra[i - 1].pose.axis), 1e-9) << "move " << i;
      EXPECT_LT(length(cross(extra[i].pose.tip - extra[i - 1].pose.tip, extra[i].pose.axis)), 1e-9);
    }
    if (set_down) {
      EXPECT_NEAR(distance(extra[i].pose.tip, extra[i - 1].pose.tip), 2.0, 1e-9);
    }
  }
  return *joints;
}

constexpr std::size_t kNoWay = 1000;

/// All tracks (branch, turn) of all poses by brute force: the fewest changes between them. A change is made
/// at a pose that both tracks reach.
std::size_t fewest_changes(const ToolPath& path, const MachineModel& m) {
  constexpr int kTurns = 5;
  constexpr std::size_t kTracks = 2 * (2 * kTurns + 1);
  std::vector<std::size_t> least(kTracks, 0);
  std::vector<bool> reached(kTracks, true);
  double unwound[2] = {};
  for (std::size_t i = 0; i < path.moves.size(); ++i) {
    const auto both = inverse(m, standing(), path.moves[i].pose, 0.0);
    const std::size_t best = *std::min_element(least.begin(), least.end());
    std::vector<std::size_t> next(kTracks, kNoWay);
    std::vector<bool> reaches(kTracks, false);
    for (int b = 0; b < 2; ++b) {
      Joints q = (*both)[static_cast<std::size_t>(b)];
      unwound[b] = i == 0 ? q.c : unwound[b] + std::remainder(q.c - unwound[b], 360.0);
      for (int k = -kTurns; k <= kTurns; ++k) {
        q.c = unwound[b] + 360.0 * k;
        const auto track = static_cast<std::size_t>(b * (2 * kTurns + 1) + k + kTurns);
        reaches[track] = within_limits(m, q);
        if (!reaches[track]) continue;
        next[track] = least[track];
        if (i > 0 && reached[track]) next[track] = std::min(next[track], best + 1);
      }
    }
    least = next;
    reached = reaches;
  }
  return std::min(kNoWay, *std::min_element(least.begin(), least.end()));
}

TEST(Operation, ConesWithinLimitsOfAllKinds) {
  // Rows: half-apex, inclination, tilt range, turn of C (K12); i = a passes the pole.
  const struct {
    double apex, inclined, tilt_min, tilt_max, c_span;
  } cones[]{{15, 10, 5, 25, 360},
            {15, 30, 15, 45, 62.35},
            {15, 15.5, 0.5, 30.5, 151.16},
            {45, 30, 15, 75, 360},
            {15, 15, 0, 30, 180}};
  const struct {
    double min, max;
  } limits[]{{-36000, 36000}, {-370, 370}, {-10, 370}, {-200, 180}, {-170, 170}, {0, 190}};
  std::printf(
      "| a | i | C limits | tilt | C turns | largest dC | off the part |\n|---|---|---|---|---|---|---|\n");
  for (const auto& row : cones) {
    for (const auto& limit : limits) {
      SCOPED_TRACE(testing::Message()
                   << "a " << row.apex << " i " << row.inclined << " C " << limit.min << " to " << limit.max);
      MachineModel m = trunnion();
      m.rotary.min = limit.min;
      m.rotary.max = limit.max;
      const ToolPath path = path_of(cone(row.apex, row.inclined));
      const auto joints = to_joints(path, m, standing(), with_detours());
      ASSERT_TRUE(joints) << joints.error().message;
      // Through the pole the tracks of the brute force are torn.
      const bool through_pole = row.apex == row.inclined;
      if (!through_pole) {
        EXPECT_EQ(joints->report.reconfigurations, fewest_changes(path, m));
      }
      EXPECT_LE(joints->report.reconfigurations, limit.max - limit.min > 360 ? 1u : 2u);
      const ToolPath& walked = joints->reconfigured ? *joints->reconfigured : path;
      const Checked worst = check_densely(walked, m, standing(), with_detours(), *joints);
      // In cut: tilt and turn of the closed form, the turn summed up without the detours.
      double low = 1e9, high = 0, turned = 0, from = 1e9, to = -1e9, largest = 0;
      for (std::size_t i = 1; i < joints->moves.size(); ++i) {
        const JointMove& move = joints->moves[i];
        if (move.kind != MoveKind::kCut) continue;
        low = std::min(low, std::abs(move.joints.a));
        high = std::max(high, std::abs(move.joints.a));
        const double step = move.joints.c - joints->moves[i - 1].joints.c;
        turned += step;
        largest = std::max(largest, std::abs(step));
        from = std::min(from, turned);
        to = std::max(to, turned);
      }
      EXPECT_NEAR(low, row.tilt_min, 0.3);
      EXPECT_NEAR(high, row.tilt_max, 0.3);
      EXPECT_NEAR(std::max(to, 0.0) - std::min(from, 0.0), row.c_span, 1.0);
      EXPECT_LT(worst.largest_turn, 180.0);
      std::printf("| %g | %g | %g..%g | %.1f..%.1f | %.1f | %.1f | %d |\n", row.apex, row.inclined, limit.min,
                  limit.max, low, high, std::max(to, 0.0) - std::min(from, 0.0), largest,
                  static_cast<int>(joints->report.reconfigurations));
    }
  }
}

ToolPath spiral(double turns, MoveKind kind = MoveKind::kCut) {
  return path_of(
      sampled(
          400,
          [&](double f) {
            const double turn = turns * 2 * kPi * f;
            return Pose{{30 * std::cos(turn), 30 * std::sin(turn), 10 * f}, axis_at(40, turns * kTurn * f)};
          }),
      kind);
}

TEST(Operation, TurnsTheTableBackAsSeldomAsTheLimitsAllow) {
  for (const double direction : {1.0, -1.0}) {
    for (const double range : {500.0, 720.0, 1080.0}) {
      SCOPED_TRACE(testing::Message() << direction << " range " << range);
      MachineModel m = trunnion();
      m.rotary.min = -range / 3;
      m.rotary.max = range * 2 / 3;
      const ToolPath path = spiral(4.25 * direction);
      const auto joints = to_joints(path, m, standing(), with_detours());
      ASSERT_TRUE(joints) << joints.error().message;
      // A start on the best turn may leave up to a turn of the range unused at each end.
      const double turn = 4.25 * kTurn;
      EXPECT_GE(joints->report.reconfigurations, static_cast<std::uint64_t>(std::ceil(turn / range) - 1));
      EXPECT_LE(joints->report.reconfigurations,
                static_cast<std::uint64_t>(std::ceil(turn / (range - 180.0)) - 1));
      expect_led_through(path, m, joints->report.reconfigurations);
    }
  }
}

TEST(Operation, WithoutAClearHeightTheLimitIsAnError) {
  MachineModel m = trunnion();
  m.rotary.min = -200;
  m.rotary.max = 200;
  const auto joints = to_joints(spiral(2), m, standing(), {});
  ASSERT_FALSE(joints);
  EXPECT_EQ(joints.error().code, Code::kLimit);
}

TEST(Operation, TurnsBackInTheAirRatherThanInCut) {
  MachineModel m = trunnion();
  m.rotary.min = -400;
  m.rotary.max = 400;
  ToolPath path = spiral(3);
  path.moves[190].kind = path.moves[191].kind = MoveKind::kRapid;
  const JointPath joints = expect_led_through(path, m, 1);
  ASSERT_TRUE(joints.reconfigured);
  std::size_t first = 0;
  while (joints.reconfigured->moves[first].pose == path.moves[first].pose) ++first;
  EXPECT_GE(first, 190u);
  EXPECT_LE(first, 192u);
  for (const Move& move : put_in(path, *joints.reconfigured)) EXPECT_NE(move.kind, MoveKind::kPlunge);
}

TEST(Operation, GoesToTheOtherSideOfTheTiltWhereOneEnds) {
  // Within 100 degrees of C either side of the tilt serves 200 degrees of the 300.
  MachineModel m = trunnion();
  m.rotary.min = -100;
  m.rotary.max = 100;
  const ToolPath path = path_of(sampled(200, [&](double f) {
    return Pose{{20, 10, 0}, axis_at(30, 10 + 300 * f)};
  }));
  const JointPath joints = expect_led_through(path, m, 1);
  bool positive = false, negative = false;
  for (const JointMove& move : joints.moves)
    if (move.kind == MoveKind::kCut) (move.joints.a > 0 ? positive : negative) = true;
  EXPECT_TRUE(positive && negative);
}

TEST(Operation, RefusesToTakeALyingToolUpwards) {
  MachineModel m = trunnion();
  m.rotary.min = -100;
  m.rotary.max = 100;
  const auto joints = to_joints(path_of(sampled(200,
                                                [&](double f) {
                                                  return Pose{{20, 10, 0}, axis_at(88, 10 + 300 * f)};
                                                })),
                                m, standing(), with_detours());
  ASSERT_FALSE(joints);
  EXPECT_EQ(joints.error().code, Code::kLimit);
  EXPECT_NE(joints.error().message.find("C "), std::string::npos) << joints.error().message;
}

/// A tilt that has wound up by nearly a turn comes back only by way of a tool that hangs head down, its tip
/// held close over the part.
TEST(Operation, RefusesToTurnTheToolOverAboveThePart) {
  MachineModel m = trunnion();
  m.tilt.min = -359;
  m.tilt.max = 359;
  const auto joints = to_joints(path_of(sampled(400,
                                                [&](double f) {
                                                  return Pose{{20, 10, 0}, axis_at(30 + 380 * f, 10)};
                                                })),
                                m, standing(), with_detours());
  ASSERT_FALSE(joints);
  EXPECT_EQ(joints.error().code, Code::kLimit);
  EXPECT_NE(joints.error().message.find("A "), std::string::npos) << joints.error().message;
}

/// Round a pin with the tool lying: three turns on a table that has two. The table is turned back with the
/// tool standing beside the work.
TEST(Operation, TakesALyingToolOutwards) {
  constexpr double kRadius = 45.0;
  for (const double tilt : {88.0, 90.0, 96.0}) {
    for (const Structure structure : {Structure::kTableHead, Structure::kTableTable}) {
      SCOPED_TRACE(testing::Message() << tilt << " degrees, structure " << static_cast<int>(structure));
      MachineModel m = trunnion();
      m.structure = structure;
      if (structure == Structure::kTableTable) m.tilt.sign = -1, m.rotary_to_tilt = {0, 0, 0};
      m.rotary.min = -360, m.rotary.max = 360;
      const Point<Part> centre = Point<Part>{} - standing().part_zero;  // of the table
      const ToolPath path = path_of(sampled(600, [&](double f) {
        const Vec3 u = axis_at(tilt, 1080 * f), out = axis_at(90, 1080 * f);
        return Pose{Point<Part>{centre.x, centre.y, 10 * f} + out * 30.0, u};
      }));
      JointPathOptions options;
      EXPECT_FALSE(to_joints(path, m, standing(), options));
      options.clear.radius = kRadius;
      const auto joints = to_joints(path, m, standing(), options);
      ASSERT_TRUE(joints) << joints.error().message;
      EXPECT_EQ(joints->report.reconfigurations, 1u);
      check_densely(*joints->reconfigured, m, standing(), options, *joints);
      put_in(path, *joints->reconfigured);
      // Where the table turns, the printed words hold the tool: nothing of it is nearer than the clear
      // radius.
      const auto off = [&](Point<Part> p) { return std::hypot(p.x - centre.x, p.y - centre.y); };
      double turned = 0.0;
      for (std::size_t i = 1; i < joints->moves.size(); ++i) {
        const Joints &p = joints->moves[i - 1].joints, &q = joints->moves[i].joints;
        const Pose pose = forward(m, standing(), q);
        if (joints->moves[i].kind != MoveKind::kRapid || q.c == p.c) continue;
        turned += std::abs(q.c - p.c);
        for (const double up : {0.0, 20.0, 100.0})
          EXPECT_GE(off(pose.tip + pose.axis * up), kRadius - 0.1) << "block " << i;
        EXPECT_LT(distance(Point<Part>{p.x, p.y, p.z}, Point<Part>{q.x, q.y, q.z}), 0.1) << "the tool stands";
      }
      EXPECT_GT(turned, 700.0);
      // A shank that points inwards would cross the work; a rotary in the head would swing the tool.
      ToolPath inward = path;
      for (Move& move : inward.moves)
        move.pose.axis = {-move.pose.axis.x, -move.pose.axis.y, move.pose.axis.z};
      EXPECT_FALSE(to_joints(inward, m, standing(), options));
    }
  }
}

TEST(Operation, PrefersASideOfTheTilt) {
  for (const int side : {+1, -1}) {
    MachineModel m = trunnion();
    m.preferred_tilt = side;
    for (const double azimuth : {0.0, 80.0, 200.0}) {
      const auto joints = to_joints(path_of({{{0, 0, 0}, axis_at(30, azimuth)}}), m, standing(), {});
      ASSERT_TRUE(joints);
      EXPECT_EQ(joints->moves[0].joints.a, 30.0 * side);
    }
  }
}

TEST(Operation, ChangesAsSeldomAsBruteForceFinds) {
  std::size_t changed = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    MachineModel m = trunnion();
    m.rotary.min = -100 - 300 * unit(random);
    m.rotary.max = 100 + 300 * unit(random);
    if (seed % 3 == 0) m.tilt.min = -10;
    double azimuth = 360 * unit(random), speed = 0;
    std::vector<Pose> poses;
    for (int i = 0; i < 250; ++i) {
      speed = std::clamp(speed + 4 * (unit(random) - 0.5), -12.0, 12.0);
      azimuth += speed;
      poses.push_back({{20 * unit(random), 10, 5}, axis_at(35 + 10 * std::sin(0.1 * i), azimuth)});
    }
    const ToolPath path = path_of(poses);
    const std::size_t fewest = fewest_changes(path, m);
    const auto joints = to_joints(path, m, standing(), with_detours());
    ASSERT_EQ(joints.has_value(), fewest < kNoWay) << (joints ? "" : joints.error().message);
    if (!joints) continue;
    EXPECT_EQ(joints->report.reconfigurations, fewest);
    changed += fewest;
  }
  EXPECT_GT(changed, 20u);
}

}  // namespace
}  // namespace tiltfeed
