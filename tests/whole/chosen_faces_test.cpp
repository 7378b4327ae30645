// Faces of a STEP part that alone are machined: what is left on them, and where the tool cuts, in closed form
// and by brute force over every cut. The part is a block [0, 40] x [0, 30] x [0, 20] without what of it is
// over x = 20 and z = 10; its upper level is red, its lower one green.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "config/part_faces.h"
#include "config/part_reading.h"
#include "pathgen/plan/plan.h"
#include "sim/solid/tool_solid.h"
#include "tests/cad/made_files.h"

namespace tiltfeed {
namespace {

constexpr double kTolerance = 0.01, kRadius = 3.0;
const std::string kBall = "{type: ball, diameter_mm: 6, length_mm: 80, shank_length_mm: 40}";

std::string choosing_job(const std::string& kind, const std::string& cutter) {
  return cad_job("step.step", "", cutter, kind);
}

struct ReadPart {
  pathgen::PartModel model;
  pathgen::CheckedMesh mesh;
};

const ReadPart& part_of(const config::Job& job) {
  static std::optional<ReadPart> part;
  if (part) return *part;
  part.emplace();
  auto model = config::read_part_model(job);
  EXPECT_TRUE(model) << model.error().message;
  auto mesh = config::check_part(job, *model);
  EXPECT_TRUE(mesh) << mesh.error().message;
  part->model = std::move(*model), part->mesh = std::move(*mesh);
  return *part;
}

struct Face {
  std::string colour;
  double low_x, high_x, z;  ///< y from 0 to 30
};
const Face kUpper{"#ff0000", 0.0, 20.0, 20.0}, kLower{"#00ff00", 20.0, 40.0, 10.0};

/// Poses of the cuts, a quarter of a millimetre apart or less.
struct Cuts {
  std::vector<Pose> poses;
  std::optional<pathgen::RestReport> uncut;
  std::vector<std::string> warnings;
};

Result<Cuts> cuts_of(const std::string& kind, const std::string& cutter, const std::string& colour,
                     double beyond, bool report = false) {
  auto job = config::parse_job(choosing_job(kind, cutter), "job.yaml");
  if (!job) return tl::unexpected(job.error());
  const ReadPart& part = part_of(*job);
  if (!colour.empty()) job->only_faces = {colour}, job->beyond_faces = beyond;
  if (auto added = config::add_chosen_faces(*job, part.model, part.mesh); !added)
    return tl::unexpected(added.error());
  job->plan.find_rest_material = report;
  const auto plan = pathgen::plan(part.mesh, job->plan, {});
  if (!plan) return tl::unexpected(plan.error());
  Cuts cuts;
  cuts.uncut = plan->report.uncut, cuts.warnings = plan->report.warnings;
  const auto& moves = plan->path.moves;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    if (moves[i].kind != MoveKind::kCut) continue;
    const int steps = 1 + static_cast<int>(distance(moves[i - 1].pose.tip, moves[i].pose.tip) / 0.25);
    for (int k = moves[i - 1].kind == MoveKind::kCut ? 1 : 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      cuts.poses.push_back({lerp(moves[i - 1].pose.tip, moves[i].pose.tip, t),
                            slerp(moves[i - 1].pose.axis, moves[i].pose.axis, t)});
    }
  }
  return cuts;
}

/// Of the rectangle, in closed form, from a ball's centre.
double off_ball(const Face& face, Point<Part> centre) {
  return length(Vec3{centre.x - std::clamp(centre.x, face.low_x, face.high_x),
                     centre.y - std::clamp(centre.y, 0.0, 30.0), centre.z - face.z}) -
         kRadius;
}

/// Of the solid, in closed form: two blocks.
double off_part(Point<Part> p) {
  const auto to_block = [&](double x, double z) {
    return length(
        Vec3{p.x - std::clamp(p.x, 0.0, x), p.y - std::clamp(p.y, 0.0, 30.0), p.z - std::clamp(p.z, 0.0, z)});
  };
  return std::min(to_block(20.0, 20.0), to_block(40.0, 10.0));
}

/// What a ball leaves of a place on all poses.
double left_at(const std::vector<Pose>& poses, Point<Part> place) {
  double left = 1e9;
  for (const Pose& pose : poses) left = std::min(left, distance(pose.tip + pose.axis * kRadius, place));
  return left - kRadius;
}

const std::string kFixed = "axis: {mode: fixed}\n",
                  kAbout = "origin_mm: [20, 15, -20], t: [1, 0, 0], n: [0, 0, 1]}\n";

TEST(ChosenFaces, AllOfThemIsCutAsItElseIsAndNothingFurtherThanTheReach) {
  struct Case {
    std::string kind;
    Face face;
    double beyond;
  };
  const std::string rows = "pattern: {kind: raster, side_step_mm: 1}\n";
  const std::vector<Case> cases{
      {kFixed + rows, kUpper, 1.0},
      {kFixed + rows, kLower, 1.0},
      {kFixed + rows, kUpper, 4.0},
      {kFixed + rows, kLower, 0.0},
      {kFixed + "pattern: {kind: raster, angle_deg: 30, measure: scallop, scallop_mm: 0.02}\n", kLower, 0.5},
      {kFixed + "pattern: {kind: split, side_step_mm: 1, step_down_mm: 1}\n", kLower, 1.0},
      {kFixed + "pattern: {kind: contour, side_step_mm: 1}\ncontainment: {x_mm: [-5, 45], y_mm: [-5, 35]}\n",
       kUpper, 1.0},
      {"axis: {mode: line, sense: outward, " + kAbout + rows, kLower, 1.0},
      {"axis: {mode: point, sense: outward, " + kAbout + rows, kUpper, 1.0},
      {"axis: {mode: circle, sense: outward, circle_radius_mm: 5, " + kAbout + rows, kUpper, 1.0},
      {"axis: {mode: free, plane_normals: [[0, 1, 0]]}\npattern: {side_step_mm: 1}\n", kUpper, 1.0},
      {"axis: {mode: free, plane_normals: [[0, 1, 0]]}\npattern: {side_step_mm: 1}\n", kLower, 1.0},
      {"axis: {mode: indexed}\npattern: {kind: raster, side_step_mm: 1}\n", kLower, 1.0}};
  for (const Case& one : cases) {
    SCOPED_TRACE(one.kind + one.face.colour + " " + std::to_string(one.beyond));
    const auto all = cuts_of(one.kind, kBall, "", 0.0);
    const auto only = cuts_of(one.kind, kBall, one.face.colour, one.beyond);
    ASSERT_TRUE(all) << all.error().message;
    ASSERT_TRUE(only) << only.error().message;
    EXPECT_LT(only->poses.size(), all->poses.size());
    // Where a ball touches a plane so far from the face's edge.
    const double reach = std::hypot(kRadius, one.beyond) - kRadius + 2.0 * kTolerance;
    double off = -1.0, deepest = 1e9;
    for (const Pose& pose : only->poses) {
      const Point<Part> centre = pose.tip + pose.axis * kRadius;
      off = std::max(off, off_ball(one.face, centre));
      deepest = std::min(deepest, off_part(centre) - kRadius);
    }
    EXPECT_LE(off, reach);
    EXPECT_GE(deepest, -kTolerance);
    double worst = 0.0, most = 0.0;
    for (double x = one.face.low_x; x <= one.face.high_x; x += 1.25)
      for (double y = 0.0; y <= 30.0; y += 1.5) {
        const Point<Part> place{x, y, one.face.z};
        const double without = left_at(all->poses, place);
        if (without > std::hypot(kRadius, one.beyond) - kRadius) continue;  // in the corner
        most = std::max(most, without);
        worst = std::max(worst, left_at(only->poses, place) - without);
      }
    // Which rows of which direction are a face's is another choice where it alone counts.
    EXPECT_LE(worst, one.kind.find("indexed") == std::string::npos ? 2.0 * kTolerance : 0.05);
    EXPECT_GT(most, -kTolerance);
  }
}

/// Off the face by the judges' own solid: a cutter with a flat end, an edge, a cone.
TEST(ChosenFaces, CuttersOfAllForms) {
  const std::string kind = kFixed + "pattern: {kind: raster, side_step_mm: 1}\n";
  for (const char* cutter :
       {"{type: flat, diameter_mm: 6, length_mm: 80, shank_length_mm: 40}",
        "{type: bull_nose, corner_radius_mm: 1, diameter_mm: 6, length_mm: 80, shank_length_mm: 40}",
        "{type: taper_ball, taper_deg: 8, diameter_mm: 4, cutting_length_mm: 25, length_mm: 80, "
        "shank_length_mm: 40}"}) {
    SCOPED_TRACE(cutter);
    const double beyond = 0.5;
    const auto job = config::parse_job(choosing_job(kind, cutter), "job.yaml");
    ASSERT_TRUE(job) << job.error().message;
    const auto all = cuts_of(kind, cutter, "", beyond), only = cuts_of(kind, cutter, kLower.colour, beyond);
    ASSERT_TRUE(all && only);
    pathgen::Mesh face;
    face.vertices = {{20, 0, 10}, {40, 0, 10}, {40, 30, 10}, {20, 30, 10}};
    face.facets = {{0, 1, 2}, {0, 2, 3}}, face.source = {0, 1};
    const sim::PartDistance surface(face);
    const sim::ToolSolid tool(job->plan.cutter);
    // Of a taper's end, the ball, without the cone that the judges count to it.
    const bool tapers = job->plan.cutter.type == pathgen::CutterType::kTaperBall;
    const auto off = [&](const Pose& pose) {
      const double ball = job->plan.cutter.nose_radius();
      return tapers ? surface.nearest(pose.tip + pose.axis * ball).value - ball
                    : tool.gap(surface, pose).value;
    };
    const double corner = job->plan.cutter.nose_radius(), reach = std::hypot(corner, beyond) - corner;
    for (const Pose& pose : only->poses) EXPECT_LE(off(pose), reach + 2.0 * kTolerance);
    // No pose is missing, but for ways between passes.
    std::size_t near = 0, missing = 0;
    for (const Pose& pose : all->poses) {
      if (off(pose) > reach) continue;
      ++near;
      missing += std::none_of(only->poses.begin(), only->poses.end(),
                              [&](const Pose& other) { return distance(pose.tip, other.tip) < 0.3; });
    }
    EXPECT_GT(near, 1000u);
    EXPECT_LT(static_cast<double>(missing), 0.02 * static_cast<double>(near));
  }
}

TEST(ChosenFaces, TheReportCallsTheOthersOutOfContainment) {
  const std::string kind = kFixed + "pattern: {kind: raster, side_step_mm: 1}\n";
  const auto only = cuts_of(kind, kBall, kUpper.colour, 1.0, true);
  ASSERT_TRUE(only) << only.error().message;
  ASSERT_TRUE(only->uncut);
  EXPECT_EQ(only->uncut->between.area, 0.0);
  // The lower level and the four walls beside and between: what faces the tool besides the red face.
  double contained = 0.0;
  for (const pathgen::RestFacet& facet : only->uncut->facets)
    if (facet.why == pathgen::RestReason::kContainment) contained += facet.share;
  EXPECT_GT(contained, 0.0);
  for (const pathgen::RestFacet& facet : only->uncut->facets)
    EXPECT_EQ(facet.why, pathgen::RestReason::kContainment);
  for (const std::string& warning : only->warnings) ADD_FAILURE() << warning;
}

TEST(ChosenFaces, WhatCannotBeIsRefused) {
  const std::string rows = kFixed + "pattern: {kind: raster, side_step_mm: 1}\n";
  const auto unknown = cuts_of(rows, kBall, "#0000ff", 1.0);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("no face has the name or colour \"#0000ff\""), std::string::npos);
  // From below neither level is seen.
  const auto away = cuts_of("axis: {mode: fixed, n: [0, 0, -1]}\npattern: {kind: raster, side_step_mm: 1}\n",
                            kBall, kUpper.colour, 1.0);
  ASSERT_FALSE(away);
  EXPECT_NE(away.error().message.find("none of the faces of containment.faces"), std::string::npos)
      << away.error().message;
  const auto refused = [](const std::string& kind, const std::string& why) {
    const auto job = config::parse_job(choosing_job(kind, kBall), "job.yaml");
    ASSERT_FALSE(job) << kind;
    EXPECT_NE(job.error().message.find(why), std::string::npos) << job.error().message;
  };
  refused(
      kFixed +
          "pattern: {kind: rough, side_step_mm: 1, step_down_mm: 1}\ncontainment: {faces: [\"#ff0000\"]}\n",
      "containment.faces: not used in the kind rough");
  refused(rows + "containment: {beyond_faces_mm: 1}\n",
          "containment.beyond_faces_mm: not used without faces");
}

}  // namespace
}  // namespace tiltfeed
