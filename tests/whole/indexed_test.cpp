// Indexed machining: how many directions a cube needs in closed form, that regions and turns are what they
// are said to be, and the whole path against the true solids and against what brute force reaches.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "tests/judges/free_cover.h"
#include "tests/judges/tool_proof.h"
#include "tests/shapes/turned_parts.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kTolerance = 0.01;

CheckedMesh cube(double half) {
  Stl stl;
  const auto quad = [&](Vec3 n, Vec3 u, Vec3 v) {
    const auto at = [&](double a, double b) { return Point<Part>{} + (n + u * a + v * b) * half; };
    stl.facets.push_back({at(-1, -1), at(1, -1), at(1, 1)});
    stl.facets.push_back({at(-1, -1), at(1, 1), at(-1, 1)});
  };
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  quad(x, y, z), quad(y, z, x), quad(z, x, y);
  quad(-x, z, y), quad(-y, x, z), quad(-z, y, x);
  return checked(stl);
}

PlanOptions options_for(double ball, double side_step) {
  PlanOptions o;
  o.name = "indexed", o.tolerance = kTolerance;
  o.cutter = {ball, 120, 60};
  o.axis.mode = AxisMode::kIndexed;
  o.pattern.side_step = side_step, o.pattern.measure = StepMeasure::kSurface;
  o.links.clearance = 5, o.links.approach = 1, o.links.join_distance = 4.0 * side_step;
  o.cut_feed = Feed::from_mm_per_min(1000), o.plunge_feed = Feed::from_mm_per_min(300);
  return o;
}

std::vector<Vec3> axes_of(const ToolPath& path) {
  std::vector<Vec3> axes;
  for (const Move& move : path.moves)
    if (move.kind == MoveKind::kCut && (axes.empty() || axes.back() != move.pose.axis))
      axes.push_back(move.pose.axis);
  return axes;
}

struct Proof {
  ToolFindings found;
  FreeCoverage cover;
};
Proof proof_of(const CheckedMesh& part, const PlanOptions& o, const ToolPath& path, int points) {
  const sim::PartDistance distances(part.mesh);
  const std::array<double, 3> clearance{0, o.shank.clearance, o.holder.clearance};
  const Reach reach(distances, part.bounds,
                    {.cutter = o.cutter,
                     .tolerance = kTolerance,
                     .clearance = clearance,
                     .up = o.up,
                     .tilt_max = o.tilt_max,
                     .steepest = o.indexed.steepest,
                     .directions = 400});
  Proof proof{ToolProof(distances, part.bounds, o.cutter, kTolerance, clearance).measure(path, 0.1), {}};
  // Contours lie a step down apart: at 45 degrees, where a split takes over, that much along the surface.
  const bool split = o.pattern.kind == PatternKind::kSplit;
  const double step = split ? std::sqrt(2.0) * o.pattern.step_down : o.pattern.side_step;
  proof.cover =
      FreeCover(part.mesh, distances, reach, {}, PassStep::kSurface, step, kTolerance).cover(path, points);
  return proof;
}

void expect_good(const Plan& plan, const Proof& proof, double least_cover) {
  for (const std::string& w : plan.report.warnings) std::printf("    %s\n", w.c_str());
  std::printf(
      "    %zu axes, %zu moves, gouge %.4f contact %.4f, cover %.4f of %zu (border %zu shallow %zu), no seat "
      "%zu, no direction %zu, worst %.3f at %.2f %.2f %.2f\n",
      axes_of(plan.path).size(), plan.path.moves.size(), proof.found.gouge(), proof.found.contact.value,
      proof.cover.share(), proof.cover.reachable, proof.cover.border, proof.cover.shallow,
      proof.cover.no_seat, proof.cover.no_direction, proof.cover.worst_excess, proof.cover.worst_at.x,
      proof.cover.worst_at.y, proof.cover.worst_at.z);
  EXPECT_LE(proof.found.gouge(), kTolerance);
  EXPECT_LE(proof.found.contact.value, kTolerance) << pasteable(proof.found.contact.at);
  EXPECT_EQ(proof.found.buried, 0u);
  EXPECT_GE(proof.cover.share(), least_cover);
}

/// The diagonal of a cube faces three sides at 54.7 degrees; where that is too steep, two sides at 45.
TEST(Indexed, CubeNeedsAsManyDirectionsAsItsGeometrySays) {
  const CheckedMesh part = cube(15.0);
  const struct {
    double steepest, tilt_max;
    std::size_t directions;
    double cover;
  } kCases[] = {
      {75, 180, 2, 0.99}, {52, 180, 3, 0.99}, {40, 180, 6, 0.99}, {75, 90, 2, 0.99}, {52, 90, 3, 0.99}};
  for (const auto& c : kCases) {
    PlanOptions o = options_for(6, 1.0);
    o.indexed.steepest = Angle::from_degrees(c.steepest), o.tilt_max = Angle::from_degrees(c.tilt_max);
    const auto made = plan(part, o, {});
    ASSERT_TRUE(made) << made.error().message;
    const auto axes = axes_of(made->path);
    EXPECT_EQ(axes.size(), c.directions) << c.steepest << ", " << c.tilt_max;
    for (const Move& move : made->path.moves)
      EXPECT_LE(angle_between(move.pose.axis, o.up), o.tilt_max.radians() + 1e-9);
    expect_good(*made, proof_of(part, o, made->path, 500), c.cover);
  }
}

CheckedMesh formula(const std::string& name) {
  Stl stl;
  stl.facets = *sim::part_by_name(name);
  return checked(stl);
}

/// Deep in a slot only directions near its own plane are clear of the holder.
TEST(Indexed, SlottedBarWithAHolder) {
  const CheckedMesh part = slotted_bar(12.0, 20.0, 40.0, 50.0);
  PlanOptions o = options_for(6, 1.0);
  o.cutter.shank_length = 30, o.cutter.holder = {{30, 30, 40}};
  o.indexed.steepest = Angle::from_degrees(89.0), o.indexed.most_directions = 8;
  o.pattern.kind = PatternKind::kSplit, o.pattern.step_down = 1.0;
  o.holder.clearance = 0.5;
  const auto made = plan(part, o, {});
  ASSERT_TRUE(made) << made.error().message;
  expect_good(*made, proof_of(part, o, made->path, 500), 0.99);
}

TEST(Indexed, Handle) {
  const CheckedMesh part = formula("handle");
  PlanOptions o = options_for(6, 1.0);
  const auto made = plan(part, o, {});
  ASSERT_TRUE(made) << made.error().message;
  for (const auto& t : made->report.times) std::printf("    %s %.2f\n", t.stage.c_str(), t.seconds);
  expect_good(*made, proof_of(part, o, made->path, 500), 0.99);
  // Pieces of passes that end beside each other are joined.
  EXPECT_GT(made->report.joins, made->report.retracts);
}

/// (I4) Between two directions the tool stays off the part by what it leaves on it, however small the
/// clearance is.
TEST(Indexed, TurnsClearOfTheStock) {
  const CheckedMesh part = formula("sphere");
  PlanOptions o = options_for(10, 8.0);
  o.indexed.most_directions = 2;
  o.allowance = 1.5, o.links.clearance = 0.5, o.links.approach = 0.4;
  const auto made = plan(part, o, {});
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_EQ(axes_of(made->path).size(), 2u);
  const sim::PartDistance distances(part.mesh);
  const ToolProof proof(distances, part.bounds, o.cutter, kTolerance, {o.allowance, 0, 0});
  EXPECT_LE(proof.measure(made->path, 0.1).gouge(), kTolerance);
}

/// Random places of the surface, by brute force: shares that any of 400 directions reaches, and any of
/// `chosen`.
struct Bounds {
  double any = 0.0, chosen = 0.0;
};
Bounds bounds_of(const CheckedMesh& part, const PlanOptions& o, const std::vector<Vec3>& chosen, int points) {
  const sim::PartDistance distances(part.mesh);
  const Reach reach(
      distances, part.bounds,
      {.cutter = o.cutter, .tolerance = kTolerance, .steepest = o.indexed.steepest, .directions = 400});
  SurfaceSample surface(part.mesh);
  Bounds bounds;
  for (int i = 0; i < points; ++i) {
    const SurfaceSample::At at = surface.next();
    const auto centre = reach.seat(at.point, at.normal);
    if (!centre) continue;
    const double least = std::cos(o.indexed.steepest.radians());
    bounds.any += reach.direction_at(*centre, at.normal) ? 1.0 / points : 0.0;
    bounds.chosen +=
        std::any_of(chosen.begin(), chosen.end(),
                    [&](Vec3 d) { return dot(d, at.normal) >= least && reach.admits(*centre, d); })
            ? 1.0 / points
            : 0.0;
  }
  return bounds;
}

/// Its inside needs a direction for every few places. What the chosen ones reach is cut, and the report says
/// how much that is and how much all would reach.
TEST(Indexed, HollowSphere) {
  const CheckedMesh part = formula("sphere");
  PlanOptions o = options_for(10, 1.5);
  o.indexed.most_directions = 12;
  const auto made = plan(part, o, {});
  ASSERT_TRUE(made) << made.error().message;
  for (const auto& t : made->report.times) std::printf("    %s %.2f\n", t.stage.c_str(), t.seconds);
  const IndexedReport& said = *made->report.indexed;
  const Bounds bounds = bounds_of(part, o, axes_of(made->path), 800);
  const Proof proof = proof_of(part, o, made->path, 250);
  std::printf("    reached %.4f of %.4f; by brute force %.4f of %.4f\n", said.reached, said.reachable,
              bounds.chosen, bounds.any);
  expect_good(*made, proof, 0.97 * bounds.chosen / bounds.any);
  EXPECT_NEAR(said.reached, bounds.chosen, 0.04);
  EXPECT_NEAR(said.reachable, bounds.any, 0.04);
  ASSERT_EQ(said.directions.size(), axes_of(made->path).size());
  for (const IndexedReport::Direction& d : said.directions)
    EXPECT_GE(d.alone, o.indexed.least_gain * said.reachable - 1e-9);
}

}  // namespace
}  // namespace tiltfeed
