// Faces of a STEP part that are not to be touched: the tool's distance from them on every move, by brute
// force.

#include <gtest/gtest.h>

#include <cmath>

#include "config/part_faces.h"
#include "config/part_reading.h"
#include "pathgen/plan/plan.h"
#include "tests/cad/made_files.h"

namespace tiltfeed {
namespace {

constexpr double kOff = 0.5, kRadius = 3.0, kShank = 40.0;

std::string avoiding_job(const std::string& part, const std::string& kind) {
  return cad_job(part, R"(, avoid_faces: ["#ff0000"], avoid_mm: 0.5)",
                 "{type: ball, diameter_mm: 6, length_mm: 80, shank_length_mm: 40}", kind);
}

struct AvoidedRun {
  double nearest = 1e9;  ///< of ball and shank to the red face, over all moves
  std::size_t cuts = 0;
};

/// The red face is the rectangle [0, 20] x [0, 30] at z = 20; places on the tool's middle line, as wide as
/// the ball.
double to_red(Point<Part> centre, Vec3 axis) {
  double least = 1e9;
  for (double up = 0.0; up <= kShank - kRadius; up += 0.1) {
    const Point<Part> p = centre + axis * up;
    least = std::min(
        least, length(Vec3{p.x - std::clamp(p.x, 0.0, 20.0), p.y - std::clamp(p.y, 0.0, 30.0), p.z - 20.0}));
  }
  return least - kRadius;
}

AvoidedRun run_avoiding(const std::string& kind, bool avoid) {
  auto job = config::parse_job(avoiding_job("step.step", kind), "job.yaml");
  EXPECT_TRUE(job) << job.error().message;
  if (!job) return {};
  auto model = config::read_part_model(*job);
  EXPECT_TRUE(model) << model.error().message;
  const auto part = config::check_part(*job, *model);
  EXPECT_TRUE(part) << part.error().message;
  if (!avoid) job->avoid_faces.clear();
  const auto added = config::add_avoided_faces(*job, *model, *part);
  EXPECT_TRUE(added) << added.error().message;
  const auto plan = pathgen::plan(*part, job->plan, [](const char*, double) { return true; });
  EXPECT_TRUE(plan) << plan.error().message;
  AvoidedRun run;
  if (!plan) return run;
  const auto& moves = plan->path.moves;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    run.cuts += moves[i].kind == MoveKind::kCut;
    const int steps = 1 + static_cast<int>(distance(moves[i - 1].pose.tip, moves[i].pose.tip) / 0.1);
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      const Vec3 axis = slerp(moves[i - 1].pose.axis, moves[i].pose.axis, t);
      const Point<Part> centre = lerp(moves[i - 1].pose.tip, moves[i].pose.tip, t) + axis * kRadius;
      run.nearest = std::min(run.nearest, to_red(centre, axis));
    }
  }
  return run;
}

TEST(AvoidedFaces, TheToolKeepsOffOnEveryMove) {
  const std::string fixed = "axis: {mode: fixed}\n";
  for (const std::string& kind :
       {fixed + "pattern: {kind: raster, side_step_mm: 1}",
        fixed + "pattern: {kind: z_level, step_down_mm: 2}",
        fixed + "pattern: {kind: contour, side_step_mm: 1}\ncontainment: {x_mm: [-10, 50], y_mm: [-10, 40]}",
        std::string("axis: {mode: line, sense: outward, origin_mm: [0, 15, 5], t: [1, 0, 0], n: [0, 0, 1]}\n"
                    "pattern: {kind: raster, side_step_mm: 1}"),
        std::string("axis: {mode: indexed}\npattern: {kind: raster, side_step_mm: 2}")}) {
    SCOPED_TRACE(kind);
    const AvoidedRun without = run_avoiding(kind, false), with = run_avoiding(kind, true);
    EXPECT_LT(without.nearest, 0.05);  // it cuts there else
    EXPECT_GE(with.nearest, kOff - 0.01);
    EXPECT_GT(with.cuts, 0u);
  }
}

/// What is said to a job that avoids these faces; the file has one more, "chip", of which no facet is left.
std::string refusal_of(const std::vector<std::string>& avoided) {
  auto job = config::parse_job(
      avoiding_job("step.step", "axis: {mode: fixed}\npattern: {kind: raster, side_step_mm: 1}"), "job.yaml");
  EXPECT_TRUE(job) << job.error().message;
  auto model = config::read_part_model(*job);
  EXPECT_TRUE(model);
  const auto part = config::check_part(*job, *model);
  EXPECT_TRUE(part);
  model->faces.emplace_back().name = "chip";
  job->avoid_faces = avoided;
  const auto done = config::add_avoided_faces(*job, *model, *part);
  return done ? "nothing was refused" : done.error().message;
}

TEST(AvoidedFaces, NamesThatAreNotThereAreRefused) {
  const std::string said = refusal_of({"#0000ff"});
  EXPECT_NE(said.find("no face has the name or colour \"#0000ff\""), std::string::npos) << said;
}

/// With no facet to keep off, the pieces of the tool that meet such faces alone would meet the whole part.
TEST(AvoidedFaces, OneOfWhichTheRepairLeavesNothingIsRefused) {
  const std::string said = refusal_of({"#ff0000", "chip"});
  EXPECT_NE(said.find("\"chip\" of part.avoid_faces is so small"), std::string::npos) << said;
}

}  // namespace
}  // namespace tiltfeed
