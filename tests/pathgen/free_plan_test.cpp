// Whole plans with a free axis against the judge's solids, and what is refused.

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "config/job.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/joints/joint_path.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "sim/solid/tool_solid.h"
#include "tests/judges/over_turned.h"
#include "tests/shapes/soup.h"
#include "tests/texts/bad_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

using soup::operator+;

PlanOptions options(const Cutter& cutter, double step) {
  PlanOptions o;
  o.name = "free";
  o.cutter = cutter;
  o.axis.mode = AxisMode::kFree;
  o.free.plane_normals = {{1, 0, 0}, {0, 0, 1}};
  o.free.max_turn = Angle::from_degrees(5);
  o.free.smoothing = cutter.radius();
  o.pattern.side_step = step;
  o.links.clearance = 3, o.links.approach = 1;
  o.cut_feed = Feed::from_mm_per_min(1000), o.plunge_feed = Feed::from_mm_per_min(300);
  return o;
}

/// Along every move, tip straight and axis on the great circle: no overlap over the tolerance in feed, none
/// at all in rapid, contact where it cuts, tilt and turn within their limits.
void expect_right(const CheckedMesh& part, const PlanOptions& o, const Plan& plan) {
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid tool(o.cutter, {o.allowance, 0.0, 0.0});
  double gouge = 0.0, gap = 0.0, rapid = 0.0, tilt = 0.0;
  const std::vector<Move>& moves = plan.path.moves;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Pose &a = moves[i - 1].pose, &b = moves[i].pose;
    const double way = distance(a.tip, b.tip) + tool.top() * angle_between(a.axis, b.axis);
    const int steps = std::max(2, static_cast<int>(way / 0.5));
    for (int k = 1; k <= steps; ++k) {
      const double f = static_cast<double>(k) / steps;
      const Pose pose{lerp(a.tip, b.tip, f), slerp(a.axis, b.axis, f)};
      tilt = std::max(tilt, angle_between(pose.axis, o.up));
      double& deepest = moves[i].kind == MoveKind::kRapid ? rapid : gouge;
      for (const sim::ToolPart p : sim::kToolParts)
        if (tool.has(p)) deepest = std::max(deepest, -tool.clearance(surface, pose, p, -deepest).value);
      if (moves[i].kind == MoveKind::kCut) gap = std::max(gap, tool.gap(surface, pose).value);
    }
  }
  EXPECT_LE(gouge, o.tolerance);
  EXPECT_LE(gap, o.tolerance);
  EXPECT_LE(rapid, o.tolerance);
  EXPECT_LE(tilt, o.tilt_max.radians() + 1e-9);
  EXPECT_LE(over_turned(o, moves), 1e-6);
  EXPECT_GT(plan.report.points, 0u);
}

CheckedMesh scaled(soup::Soup soup, double by) {
  for (auto& f : soup)
    for (Point<Part>& p : f) p = {p.x * by, p.y * by, p.z * by};
  return soup::check(soup);
}

Result<Plan> planned(const CheckedMesh& part, const PlanOptions& o) { return plan(part, o, {}); }

TEST(FreePlan, AnAngleIsMachinedAllRoundWithoutGouge) {
  const CheckedMesh part = scaled(soup::ell(), 4);
  const PlanOptions o = options({.diameter = 4, .length = 90, .shank_length = 60}, 2);
  const auto plan = planned(part, o);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  expect_right(part, o, *plan);
  EXPECT_EQ(plan->report.free->unreached.size(), 0u);
}

TEST(FreePlan, ATorusWithAHolderLeadAndATiltLimit) {
  const CheckedMesh part = scaled(soup::torus(), 4);
  PlanOptions o =
      options({.diameter = 6, .length = 90, .shank_length = 25, .holder = {{16, 24, 20}, {24, 24, 60}}}, 4);
  o.free.lead = Angle::from_degrees(10), o.free.lean = Angle::from_degrees(-5);
  o.tilt_max = Angle::from_degrees(100);
  o.allowance = 0.2;
  const auto plan = planned(part, o);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  expect_right(part, o, *plan);
}

/// On a great circle the axis leans over further than at both its ends, and under the part it turns much
/// faster than the tip goes over the sphere: by 0.001, 0.003 and 0.03 degrees beyond these limits.
TEST(FreePlan, AWayUnderThePartKeepsTheTiltLimit) {
  const auto expect_within = [](const soup::Soup& soup, double diameter, double step, double limit, Vec3 up) {
    const CheckedMesh part = scaled(soup, 4);
    PlanOptions o = options({.diameter = diameter, .length = 90, .shank_length = 60}, step);
    o.tilt_max = Angle::from_degrees(limit);
    o.up = up;
    const auto plan = planned(part, o);
    ASSERT_TRUE(plan.has_value()) << plan.error().message;
    expect_right(part, o, *plan);
  };
  expect_within(soup::ell(), 3, 3, 105, {0, 0, 1});
  expect_within(soup::cube(0, 5), 6, 3, 105, {-1, 0, 0});
  expect_within(soup::torus(), 6, 6, 95, {0, -1, 0});
}

TEST(FreePlan, AThroughHoleIsEnteredAndLeftAlongTheAxis) {
  Stl stl;
  stl.facets = sim::hollow_sphere();
  const Result<CheckedMesh> part = check_mesh(stl);
  PlanOptions o = options({.diameter = 10, .length = 200, .shank_length = 150}, 20);
  o.free.plane_normals = {{0, 0, 1}};
  const auto plan = planned(*part, o);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  expect_right(*part, o, *plan);
  std::size_t inside = 0;
  for (const Move& m : plan->path.moves)
    inside += m.kind == MoveKind::kCut && length(from_origin(m.pose.tip)) < 41.0 ? 1 : 0;
  EXPECT_GT(inside, 100u);
}

TEST(FreePlan, ATaperIsHeldOffByItsFlank) {
  const CheckedMesh part = scaled(soup::ell(), 4);
  const PlanOptions o = options({.diameter = 3,
                                 .length = 90,
                                 .shank_length = 60,
                                 .type = CutterType::kTaperBall,
                                 .taper = Angle::from_degrees(5),
                                 .cutting_length = 30},
                                3);
  const auto plan = planned(part, o);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  expect_right(part, o, *plan);
}

TEST(FreePlan, WhatNoDirectionReachesIsReportedByFacetAndReason) {
  const CheckedMesh part = soup::check(soup::cube(0, 40) + soup::reversed(soup::cube(10, 30)));
  const PlanOptions o = options({.diameter = 6, .length = 90, .shank_length = 60}, 5);
  const auto plan = planned(part, o);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  expect_right(part, o, *plan);
  std::size_t shut = 0;
  for (const FreeReport::Facet& f : plan->report.free->unreached) {
    EXPECT_GE(f.facet, 12u);  // of the void
    EXPECT_EQ(f.why, RestReason::kCutter);
    ++shut;
  }
  EXPECT_GE(shut, 8u);
  EXPECT_GT(plan->report.free->unreached_length, 100.0);
  ASSERT_FALSE(plan->report.warnings.empty());
  EXPECT_NE(plan->report.warnings.back().find("use a smaller cutter"), std::string::npos);
}

TEST(FreePlan, NeighbouringPassesAreJoinedInContact) {
  const CheckedMesh part = scaled(soup::torus(), 4);
  PlanOptions o = options({.diameter = 6, .length = 90, .shank_length = 60}, 2);
  o.free.max_turn = Angle::from_degrees(15);
  const auto apart = planned(part, o);
  ASSERT_TRUE(apart.has_value()) << apart.error().message;
  EXPECT_EQ(apart->report.joins, 0u);
  o.links.join_distance = 4;
  const auto joined = planned(part, o);
  ASSERT_TRUE(joined.has_value()) << joined.error().message;
  expect_right(part, o, *joined);
  EXPECT_GT(joined->report.joins, 10u);
  EXPECT_EQ(apart->report.retracts + apart->report.free->short_links,
            joined->report.retracts + joined->report.free->short_links + joined->report.joins);
  EXPECT_LT(joined->report.rapid_length, apart->report.rapid_length);
}

/// Short links turn the axis close over the part, through its holes too: they keep off it by what the axes
/// may stray on a rapid, tip and axis.
TEST(FreePlan, RapidsThatTurnKeepOffThePartByWhatTheyStray) {
  Stl stl;
  stl.facets = sim::hollow_sphere();
  const CheckedMesh part = *check_mesh(stl);
  PlanOptions o = options({.diameter = 10, .length = 160, .shank_length = 110}, 2);
  o.tilt_max = Angle::from_degrees(30);
  o.links.clearance = 5;
  const auto plan = planned(part, o);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid tool(o.cutter);
  const double stray = 2.0 * kRapidToleranceFactor * ToleranceBudget(o.tolerance).joints();
  double nearest = 1.0;
  std::size_t turned = 0;
  const std::vector<Move>& moves = plan->path.moves;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Pose &a = moves[i - 1].pose, &b = moves[i].pose;
    if (moves[i].kind != MoveKind::kRapid || angle_between(a.axis, b.axis) < 1e-6) continue;
    ++turned;
    for (int k = 0; k <= 8; ++k)
      for (const sim::ToolPart p : sim::kToolParts)
        nearest = std::min(
            nearest,
            tool.clearance(surface, {lerp(a.tip, b.tip, k / 8.0), slerp(a.axis, b.axis, k / 8.0)}, p, nearest)
                .value);
  }
  EXPECT_GT(turned, 100u);
  EXPECT_GE(nearest, stray);
}

TEST(FreePlan, IsTheSameForAnyNumberOfThreads) {
  const CheckedMesh part = scaled(soup::torus(), 4);
  const PlanOptions o = options({.diameter = 6, .length = 90, .shank_length = 60}, 4);
  std::vector<std::vector<Move>> paths;
  for (const std::size_t threads : {1u, 4u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    paths.push_back(planned(part, o)->path.moves);
  }
  ASSERT_EQ(paths[0].size(), paths[1].size());
  for (std::size_t i = 0; i < paths[0].size(); ++i) ASSERT_EQ(paths[0][i].pose, paths[1][i].pose) << i;
}

TEST(FreePlan, CanBeCancelledInEveryStage) {
  const CheckedMesh part = scaled(soup::ell(), 4);
  const PlanOptions o = options({.diameter = 4, .length = 90, .shank_length = 60}, 4);
  for (const std::string stop : {"CL surface", "orientation", "link"}) {
    const auto plan =
        tiltfeed::pathgen::plan(part, o, [&](const char* stage, double) { return stage != stop; });
    ASSERT_FALSE(plan.has_value()) << stop;
    EXPECT_EQ(plan.error().code, Code::kCancelled);
  }
}

TEST(FreePlan, RefusesWhatItCannotDo) {
  const CheckedMesh part = scaled(soup::ell(), 4);
  PlanOptions o = options({.diameter = 4, .length = 90, .shank_length = 60}, 4);
  o.free.plane_normals.clear();
  EXPECT_EQ(planned(part, o).error().code, Code::kInput);
  o = options({.diameter = 4, .length = 90, .shank_length = 60, .type = CutterType::kFlat}, 4);
  EXPECT_EQ(planned(part, o).error().code, Code::kInput);
  o = options({.diameter = 4, .length = 90, .shank_length = 60}, 4);
  o.containment.first = {1000.0, 2000.0};
  EXPECT_EQ(planned(part, o).error().code, Code::kUnreachable);
  const CheckedMesh shut = soup::check(soup::cube(0, 40) + soup::reversed(soup::cube(10, 30)));
  o = options({.diameter = 4, .length = 90, .shank_length = 60}, 4);
  o.containment = {{11, 29}, {11, 29}, {11, 29}, {}};
  const auto nothing = planned(shut, o);
  ASSERT_FALSE(nothing.has_value());
  EXPECT_EQ(nothing.error().code, Code::kUnreachable);
  EXPECT_NE(nothing.error().message.find("nothing is left to cut"), std::string::npos);
}

const std::string kFreeJob =
    "part: {name: p-1, stl: p.stl}\n"                                              // 1
    "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}\n"  // 2
    "axis:\n"                                                                      // 3
    "  mode: free\n"                                                               // 4
    "  plane_normals: [[0, 0, 2], [1, 0, 0]]\n"                                    // 5
    "  lead_deg: 10\n"                                                             // 6
    "pattern: {side_step_mm: 0.5}\n"                                               // 7
    "containment: {z_mm: [0, 10]}\n"                                               // 8
    "clearance_mm: 5\n"                                                            // 9
    "approach_mm: 1\n"                                                             // 10
    "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300}\n"                      // 11
    "setup: {part_zero_mm: [1, 2, 3]}\n"                                           // 12
    "machine: ../machines/generic-ac.yaml\n";                                      // 13
const std::string kPath = SOURCE_DIR "/config/jobs/t.yaml";

TEST(FreeJob, IsReadAndDescribed) {
  const Result<Job> job = parse_job(kFreeJob, kPath);
  ASSERT_TRUE(job.has_value()) << job.error().message;
  EXPECT_EQ(job->plan.axis.mode, AxisMode::kFree);
  ASSERT_EQ(job->plan.free.plane_normals.size(), 2u);
  EXPECT_EQ(job->plan.free.plane_normals[0], (Vec3{0, 0, 1}));
  EXPECT_DOUBLE_EQ(job->plan.free.lead.degrees(), 10.0);
  EXPECT_EQ(job->plan.free.smoothing, 3.0);  // the cutter's radius
  // The head tilts by 7200 degrees/min, 7.2 degrees per mm of the tip's way.
  EXPECT_NEAR(job->plan.free.max_turn.degrees(), 7.2 / (1.0 + 3.0 * 7.2 * kPi / 180.0), 1e-9);
  EXPECT_EQ(job->plan.containment.height.high, 10.0);
  const std::string text = describe(*job);
  for (const char* line : {"axis.mode: free\n", "axis.plane_normals[2]: [1, 0, 0]\n",
                           "axis.max_turn_deg_per_mm: 5.228", "containment.z_mm: [0, 10]\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

TEST(FreeJob, EveryKindOfBadInputHasItsPlace) {
  const BadText table[] = {
      {"  plane_normals: [[0, 0, 2], [1, 0, 0]]\n", "", "4:3", "plane_normals"},
      {"[[0, 0, 2], [1, 0, 0]]", "[0, 0, 1]", "5:19", "three numbers [x, y, z]"},
      {"[[0, 0, 2], [1, 0, 0]]", "[]", "5:18", "1 to 8 directions"},
      {"[[0, 0, 2], [1, 0, 0]]", "[[0, 0, 0]]", "5:19", "zero vector"},
      {"[[0, 0, 2], [1, 0, 0]]", "[[0, 0]]", "5:19", "three numbers"},
      {"lead_deg: 10", "lead_deg: 90", "6:13", "below 85"},
      {"lead_deg: 10", "max_turn_deg_per_mm: 0", "6:24", "above 0"},
      {"lead_deg: 10", "smoothing_mm: -1", "6:17", "at least 0"},
      {"lead_deg: 10", "sense: outward", "6:10", "not used in the mode free"},
      {"lead_deg: 10", "t: [1, 0, 0]", "6:6", "not used in the mode free"},
      {"mode: free", "mode: fixed", "5:18", "only in free"},
      {"type: ball", "type: flat", "2:9", "use ball or taper_ball"},
      {"{side_step_mm: 0.5}", "{side_step_mm: 0.5, along: x}", "7:37", "not used in the axis mode free"},
      {"{side_step_mm: 0.5}", "{kind: z_level, step_down_mm: 0.5}", "7:17", "expected raster"},
      {"{z_mm: [0, 10]}", "{boundary: [[0, 0], [1, 0], [0, 1]]}", "8:25", "a box"},
      {"{z_mm: [0, 10]}", "{rho_mm: [0, 1]}", "8:23", "coordinates are x_mm, y_mm, z_mm"},
      {"approach_mm: 1\n", "approach_mm: 1\nstock: {radial_mm: 0.1}\n", "11:20", "use allowance_mm"},
      {"approach_mm: 1\n", "approach_mm: 1\nguards: {shank: {reaction: retract}}\n", "11:17",
       "expected trim"},
      {"approach_mm: 1\n", "approach_mm: 1\npoints: {smoothing_mm: 1}\n", "11:24", "expected 0"},
      {"approach_mm: 1\n", "approach_mm: 1\nlinks: {lead_radius_mm: 1}\n", "11:25", "expected 0"},
  };
  for (const BadText& bad : table)
    expect_bad(parse_job(replaced(kFreeJob, bad.from, bad.to), kPath), kPath, bad);
}

}  // namespace
}  // namespace tiltfeed
