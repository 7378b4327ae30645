// The bend near the pole on a real part: every bent pose against the true solids of cutter, shank and holder.

#include "daemon/post/near_singularity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "daemon/post/part_extent.h"
#include "pathgen/tool/move_collision.h"
#include "sim/solid/tool_solid.h"
#include "tests/judges/joint_path_check.h"
#include "tests/shapes/box_mesh.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

constexpr double kBall = 3.0;

Cutter cutter() {
  Cutter tool{2.0 * kBall, 100.0, 60.0};
  tool.holder = {{20.0, 30.0, 30.0}};
  return tool;
}

PlanOptions options() {
  PlanOptions o;
  o.cutter = cutter();
  o.tolerance = 0.01;
  return o;
}

/// A floor, and a beam over it whose lower edge is 20 mm up and whose face is at `face`.
CheckedMesh floor_and_beam(double face) {
  CheckedMesh part;
  part.mesh = box_mesh(
      {{Vec3{-200, -100, -10}, Vec3{200, 100, 0}}, {Vec3{-200, face, 20}, Vec3{200, face + 10, 35}}});
  part.bounds = {part.mesh.vertices[0], part.mesh.vertices[0]};
  for (const Point<Part> v : part.mesh.vertices) part.bounds = grown(part.bounds, v);
  return part;
}

/// Along the floor, the axis leaning from -40 to 40 degrees along the way, and a little away from the beam.
ToolPath along_the_beam(double away_deg) {
  const double d = Angle::from_degrees(away_deg).radians();
  std::vector<Pose> poses;
  for (int i = 0; i <= 160; ++i) {
    const double s = Angle::from_degrees(-40.0 + 0.5 * i).radians();
    const Vec3 axis =
        normalized(Vec3{0, -std::sin(d), std::cos(d)} * std::cos(s) + Vec3{1, 0, 0} * std::sin(s));
    const Point<Part> centre{-40.0 + 0.5 * i, 0, kBall};
    poses.push_back({centre - axis * kBall, axis});
  }
  return joint_check::path_of(poses);
}

/// How deep any part of the tool is in the part on the way, looked at every 0.05 mm or so.
double deepest(const CheckedMesh& part, const ToolPath& path) {
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid tool(cutter());
  double worst = 0.0;
  for (std::size_t i = 1; i < path.moves.size(); ++i)
    for (int k = 1; k <= 10; ++k) {
      const Pose &a = path.moves[i - 1].pose, &b = path.moves[i].pose;
      const Pose pose{lerp(a.tip, b.tip, k / 10.0), slerp(a.axis, b.axis, k / 10.0)};
      for (const sim::ToolPart piece : sim::kToolParts)
        worst = std::max(worst, -tool.clearance(surface, pose, piece, -worst).value);
    }
  return worst;
}

struct Shop {
  Job job;
  CheckedMesh part;
  ToolPath path;
};

Shop shop(double face, double away_deg, double tolerance_deg) {
  Shop s{{}, floor_and_beam(face), along_the_beam(away_deg)};
  s.job.plan = options();
  s.job.machine.model = joint_check::trunnion();
  s.job.setup = joint_check::standing();
  s.job.axis_tolerance = Angle::from_degrees(tolerance_deg);
  return s;
}

TEST(NearPole, NothingLeansWithoutLeave) {
  Shop s = shop(5.0, 0.8, 0.0);
  const ToolPath before = s.path;
  EXPECT_EQ(bend_near_singularity(s.job, s.part, s.path).stretches, 0u);
  ASSERT_EQ(s.path.moves.size(), before.moves.size());
  for (std::size_t i = 0; i < before.moves.size(); ++i) EXPECT_EQ(s.path.moves[i].pose, before.moves[i].pose);
}

TEST(NearPole, LeansTowardsTheBeamOnlyAsFarAsThereIsRoom) {
  for (const double face : {2.8, 2.9, 3.4, 6.0}) {
    SCOPED_TRACE(testing::Message() << "beam at " << face);
    Shop s = shop(face, 0.8, 1.5);
    ASSERT_LE(deepest(s.part, s.path), s.job.plan.tolerance) << "as planned";
    const ToolPath planned = s.path;
    const SingularityBendReport report = bend_near_singularity(s.job, s.part, s.path);
    EXPECT_EQ(report.stretches, 1u);
    EXPECT_LE(report.largest.degrees(), 1.5 + 1e-9);
    EXPECT_LE(deepest(s.part, s.path), s.job.plan.tolerance);
    // The ball is where it was: at the floor, as deep and as high as planned.
    for (const Move& move : s.path.moves)
      EXPECT_NEAR((move.pose.tip + move.pose.axis * kBall).z, kBall, 1e-3);
    // Without the check the tool would lean into the beam where there is no room at the pole.
    const SingularityBend blind =
        bend_at_singularity(planned, s.job.machine.model, s.job.setup, {s.job.axis_tolerance, 0.001},
                            [](const Pose&, const Pose&) { return true; });
    double pole = 90.0, blind_pole = 90.0;
    for (const Move& move : s.path.moves)
      pole = std::min(pole, angle_between(move.pose.axis, {0, 0, 1}) * 180 / kPi);
    for (const Move& move : blind.path.moves)
      blind_pole = std::min(blind_pole, angle_between(move.pose.axis, {0, 0, 1}) * 180 / kPi);
    EXPECT_LT(blind_pole, 1e-3) << "through the pole";
    if (face < 2.95) {
      EXPECT_GT(deepest(s.part, blind.path), 3.0 * s.job.plan.tolerance);
      EXPECT_GT(pole, 1.0) << "round it on the other side";
    }
    if (face > 3.05) {
      EXPECT_LT(pole, 1e-3) << "through the pole";
    }
  }
}

TEST(SpaceAbout, IsThatOfThePartAndTheTool) {
  Shop s = shop(40.0, 0.8, 0.0);
  s.job.plan.links.clearance = 5.0;
  s.job.plan.allowance = 0.25;
  // The beam's upper edge is the highest; the floor's corner the furthest from the table's axis, which is at
  // minus part zero. The holder is the tool's widest.
  const ClearSpace space = part_extent(s.part.mesh, s.job);
  const Vec3 zero = s.job.setup.part_zero;
  EXPECT_NEAR(*space.height, 35.0 + 5.25, 1e-9);
  EXPECT_NEAR(*space.radius, std::hypot(200.0 + std::abs(zero.x), 100.0 + std::abs(zero.y)) + 5.25 + 15.0,
              1e-9);
  // Laid on its side the part is as high as it was wide.
  s.job.setup.fixture = rotation_about({1, 0, 0}, kPi / 2);
  EXPECT_NEAR(*part_extent(s.part.mesh, s.job).height, 100.0 + 5.25, 1e-9);
}

/// Its answers about single moves against the solids, at poses so close that nothing slips through.
TEST(NearPole, TheCheckOfAMoveIsRight) {
  const PlanOptions o = options();
  const CheckedMesh part = floor_and_beam(4.0);
  const MoveCollision check(part.mesh, o);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int clear = 0, stopped = 0;
  for (int round = 0; round < 400; ++round) {
    const auto pose = [&](double x) {
      const Vec3 axis = normalized(Vec3{0.3 * unit(random), 0.15 * unit(random), 1.0});
      return Pose{Point<Part>{x, 0.5 * unit(random), kBall} - axis * kBall, axis};
    };
    const Pose a = pose(0.0), b = pose(2.0 * unit(random));
    ToolPath move = joint_check::path_of({a, b});
    const double depth = deepest(part, move);
    if (check.clear(a, b)) {
      ++clear;
      EXPECT_LE(depth, o.tolerance) << "round " << round;
    } else if (depth > 0.0) {
      ++stopped;
    }
    if (depth > o.tolerance) {
      EXPECT_FALSE(check.clear(a, b)) << "round " << round;
    }
  }
  EXPECT_GT(clear, 50);
  EXPECT_GT(stopped, 50);
}

}  // namespace
}  // namespace tiltfeed
