// The first and the last way of a planned path, against the true solids of cutter, shank and holder.

#include "daemon/post/end_ways.h"

#include <gtest/gtest.h>

#include <random>

#include "sim/solid/tool_solid.h"
#include "tests/judges/joint_path_check.h"
#include "tests/shapes/box_mesh.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

constexpr double kClearance = 5.0;
// The machine's Z is tried so far up, mm.
constexpr double kUp = 400.0;

Job job() {
  Job job;
  job.plan.cutter = {6.0, 100.0, 60.0};
  job.plan.cutter.holder = {{20.0, 30.0, 30.0}};
  job.plan.tolerance = 0.01;
  job.plan.links.clearance = kClearance;
  job.machine.model = wide_machine();
  job.machine.model.tilt.direction = {1, 0, 0};
  job.setup.tool_length = 100.0;
  return job;
}

/// A floor with a roof over it, whose edge is at y = `edge`.
Mesh floor_and_roof(double edge) {
  return box_mesh({{Vec3{-100, -100, -10}, Vec3{100, 100, 0}}, {Vec3{-100, -100, 60}, Vec3{100, edge, 70}}});
}

Pose leaning(Point<Part> tip, double degrees, double round_degrees = 90.0) {
  const double lean = Angle::from_degrees(degrees).radians(),
               round = Angle::from_degrees(round_degrees).radians();
  return {tip, {std::sin(lean) * std::cos(round), std::sin(lean) * std::sin(round), std::cos(lean)}};
}

ToolPath path_of(const Pose& first, const Pose& last) { return joint_check::path_of({first, last}); }

/// How near to the part any of the tool comes on the straight way, looked at every half mm.
double nearest(const sim::PartDistance& surface, const sim::ToolSolid& tool, const Pose& from, Vec3 way) {
  const int steps = static_cast<int>(std::ceil(length(way) / 0.5));
  double least = kClearance + 1.0;
  for (int i = 0; i <= steps; ++i) {
    const Pose pose{from.tip + way * (static_cast<double>(i) / std::max(steps, 1)), from.axis};
    for (const sim::ToolPart part : sim::kToolParts)
      least = std::min(least, tool.clearance(surface, pose, part, least).value);
  }
  return least;
}

Vec3 way_between(const Move& from, const Move& to) { return to.pose.tip - from.pose.tip; }

TEST(EndWays, FromUnderARoofAlongTheToolThenUp) {
  const Job j = job();
  const Mesh mesh = floor_and_roof(30.0);
  const sim::PartDistance surface(mesh);
  const sim::ToolSolid tool(j.plan.cutter);
  const Pose first = leaning({0, 0, 8}, 60.0), last = leaning({20, 10, 8}, 62.0);
  ToolPath path = path_of(first, last);
  ASSERT_LT(nearest(surface, tool, first, Vec3{0, 0, kUp}), -1.0) << "straight down the roof is in the way";
  const double put_in = add_end_ways(path, mesh, j);
  ASSERT_EQ(path.moves.size(), 4u);
  EXPECT_EQ(path.moves[1].pose, first);
  EXPECT_EQ(path.moves[2].pose, last);
  const double down = length(way_between(path.moves[1], path.moves[0])),
               off = length(way_between(path.moves[2], path.moves[3]));
  EXPECT_NEAR(put_in, down + off, 1e-9);
  for (const auto& [end, at] : {std::pair{path.moves[0], path.moves[1]}, {path.moves[3], path.moves[2]}}) {
    EXPECT_EQ(end.kind, MoveKind::kRapid);
    EXPECT_EQ(end.pose.axis, at.pose.axis);
    EXPECT_LT(length(cross(normalized(way_between(at, end)), at.pose.axis)), 1e-9) << "along the tool";
    EXPECT_GT(nearest(surface, tool, at.pose, way_between(at, end)), 0.0);
    EXPECT_GT(nearest(surface, tool, end.pose, Vec3{0, 0, kUp}), kClearance - 1e-6);
  }
}

/// Where the guards' clearances leave no way, one that is clear of the part is better than none.
TEST(EndWays, NearerThanTheClearancesWhereThereIsNoOther) {
  Job j = job();
  j.plan.shank.clearance = j.plan.holder.clearance = 40.0;
  const Mesh mesh = floor_and_roof(30.0);
  const sim::PartDistance surface(mesh);
  const sim::ToolSolid tool(j.plan.cutter);
  const Pose first = leaning({0, 0, 8}, 60.0);
  ToolPath path = path_of(first, first);
  ASSERT_GT(add_end_ways(path, mesh, j), 0.0);
  const Vec3 way = way_between(path.moves[1], path.moves[0]);
  EXPECT_GT(nearest(surface, tool, first, way), 0.0);
  EXPECT_GT(nearest(surface, tool, path.moves[0].pose, Vec3{0, 0, kUp}), kClearance - 1e-6);
}

TEST(EndWays, NothingWhereTheToolStandsUpright) {
  const Mesh mesh = floor_and_roof(-80.0);
  ToolPath path = path_of(leaning({0, 0, 8}, 0.0), leaning({20, 10, 8}, 0.0));
  EXPECT_EQ(add_end_ways(path, mesh, job()), 0.0);
  EXPECT_EQ(path.moves.size(), 2u);
}

TEST(EndWays, NothingOnATrunnionWhoseSpindleStands) {
  Job j = job();
  j.machine.model.structure = Structure::kTableTable;
  const Mesh mesh = floor_and_roof(30.0);
  ToolPath path = path_of(leaning({0, 0, 8}, 60.0), leaning({20, 10, 8}, 62.0));
  EXPECT_EQ(add_end_ways(path, mesh, j), 0.0);
}

TEST(EndWays, NothingBeyondTheTravelsNorThroughThePart) {
  const Mesh mesh = floor_and_roof(30.0);
  Job j = job();
  for (LinearAxis* axis : {&j.machine.model.x, &j.machine.model.y}) axis->min = -240, axis->max = 240;
  ToolPath path = path_of(leaning({0, 0, 8}, 60.0), leaning({0, 0, 8}, 60.0));
  EXPECT_EQ(add_end_ways(path, mesh, j), 0.0) << "the pivot would be further off";
  // Over the whole length of the axis the roof is in the way.
  ToolPath under = path_of(leaning({0, -40, 8}, 60.0), leaning({0, -40, 8}, 60.0));
  EXPECT_EQ(add_end_ways(under, floor_and_roof(100.0), job()), 0.0);
}

/// Over a wide plate the ball's lowest point, or that of the holder's edges, ends at the clearance.
TEST(EndWays, OverTheTopByTheClearance) {
  const Mesh plate = box_mesh({{Vec3{-400, -400, -10}, Vec3{400, 400, 0}}});
  const sim::PartDistance surface(plate);
  for (const auto& [type, degrees] : {std::pair{CutterType::kBall, 20.0},
                                      {CutterType::kFlat, 45.0},
                                      {CutterType::kBall, 76.0},
                                      {CutterType::kFlat, 82.0}}) {
    SCOPED_TRACE(degrees);
    Job j = job();
    j.plan.cutter.holder = {{20.0, 50.0, 50.0}};
    j.plan.cutter.type = type;
    const double lean = Angle::from_degrees(degrees).radians();
    const double lowest = std::min(
        {type == CutterType::kFlat ? -3.0 * std::sin(lean) : 3.0 * std::cos(lean) - 3.0,
         60.0 * std::cos(lean) - 10.0 * std::sin(lean), 110.0 * std::cos(lean) - 25.0 * std::sin(lean)});
    const Pose start = leaning({0, 0, 2.0 - lowest}, degrees);
    ToolPath path = path_of(start, start);
    add_end_ways(path, plate, j);
    ASSERT_EQ(path.moves.size(), 4u);
    EXPECT_NEAR(path.moves[0].pose.tip.z + lowest, kClearance, 1e-9);
    EXPECT_NEAR(nearest(surface, sim::ToolSolid(j.plan.cutter), path.moves[0].pose, {}), kClearance, 1e-6);
  }
}

/// Wherever the tool comes from: from there it goes up clear of everything.
TEST(EndWays, UpIsClearWhereverTheyEnd) {
  std::mt19937 random(11);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::size_t put_in = 0;
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    Job j = job();
    if (i % 3 == 1) j.plan.cutter.holder.clear();
    if (i % 3 == 2) j.plan.cutter.type = CutterType::kFlat;
    const Vec3 low{between(-60, 0), between(-60, 0), between(-40, 0)},
        high{between(5, 60), between(5, 60), between(5, 40)};
    const Mesh mesh = box_mesh({{low, high}});
    const sim::PartDistance surface(mesh);
    const sim::ToolSolid tool(j.plan.cutter);
    const Pose pose =
        leaning({between(-100, 100), between(-100, 100), between(-40, 80)}, between(1, 115), between(0, 360));
    if (nearest(surface, tool, pose, {}) < 1.0) continue;
    ToolPath path = path_of(pose, pose);
    if (add_end_ways(path, mesh, j) == 0.0) continue;
    ++put_in;
    ASSERT_EQ(path.moves.size(), 4u);
    EXPECT_GT(nearest(surface, tool, pose, way_between(path.moves[1], path.moves[0])), 0.0);
    EXPECT_GT(nearest(surface, tool, path.moves[0].pose, Vec3{0, 0, kUp}), kClearance - 1e-6);
  }
  EXPECT_GT(put_in, 20u);
}

/// Stock as thick as half of the approach may stand on the roof's edge: nearer than that no rapid comes.
TEST(EndWays, BesideStockTheyArePlunges) {
  Job j = job();
  j.plan.cutter.holder.clear();
  const Mesh mesh = floor_and_roof(84.0);
  const sim::PartDistance surface(mesh);
  const sim::ToolSolid tool(j.plan.cutter);
  const Pose end = leaning({0, 0, 8}, 60.0);
  ToolPath path = path_of(end, end);
  ASSERT_GT(add_end_ways(path, mesh, j), 0.0);
  const double near = nearest(surface, tool, end, way_between(path.moves[1], path.moves[0]));
  ASSERT_LT(near, kClearance);
  for (const double share : {0.9, 1.1}) {
    j.plan.links.approach = 2.0 * share * near;
    path = path_of(end, end);
    add_end_ways(path, mesh, j);
    for (const std::size_t move : {1u, 3u})
      EXPECT_EQ(path.moves[move].kind, share < 1.0 ? MoveKind::kRapid : MoveKind::kPlunge) << move;
  }
}

/// What is kept off fixtures is not kept off the part, which lies before them in the mesh.
TEST(EndWays, TheRoomOfFixturesIsThatOfFixtures) {
  Job j = job();
  j.plan.fixture_room = {40.0, 40.0, 40.0};
  const Mesh floor = box_mesh({{Vec3{-100, -100, -10}, Vec3{100, 100, 0}}}),
             roof = box_mesh({{Vec3{-100, -100, 60}, Vec3{100, 30, 70}}}),
             post = box_mesh({{Vec3{-100, -100, -10}, Vec3{-95, -95, 0}}});
  const Pose end = leaning({0, 0, 8}, 60.0);
  for (const bool roof_is_fixture : {false, true}) {
    auto fixtures = std::make_shared<Fixtures>();
    fixtures->mesh = roof_is_fixture ? roof : post, fixtures->names = {"fixture"};
    j.plan.fixtures = fixtures;
    const Mesh part = roof_is_fixture ? floor : joined(floor, roof);
    ToolPath path = path_of(end, end);
    EXPECT_EQ(add_end_ways(path, joined(part, fixtures->mesh), j) > 0.0, !roof_is_fixture);
  }
}

}  // namespace
}  // namespace tiltfeed
