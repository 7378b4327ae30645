// Rounded concave corners: the closed form of a groove, and the true ball against the facets.
#include "pathgen/envelope/smoothing.h"

#include <gtest/gtest.h>

#include "sim/solid/distance.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kSmoothing = 3.0;

PlanOptions smooth_options(const AxisFrame& axis) {
  PlanOptions o = options_with(axis);
  o.smoothing = kSmoothing;
  return o;
}

/// Walls of 45 degrees, 8 mm up from y = 0.
CheckedMesh groove() {
  return sheet(kUpright, {-3, 3, -8, 8, 6, 32}, [](double, double y) { return std::abs(y); });
}

TEST(Smoothing, AGrooveOfTwoPlanesGetsAnArc) {
  PlanOptions o = smooth_options(kUpright);
  o.pattern.along = Along::kY;
  const double r = o.cutter.radius();
  const auto planned = plan(groove(), o, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  const auto runs = runs_of(planned->path);
  ASSERT_GE(runs.size(), 3u);
  const double foot = kSmoothing / std::sqrt(2.0);  // where the arc meets the walls
  for (const CutRun& run : dense(runs, 0.05))
    for (const Pose& pose : run) {
      const double y = std::abs(pose.tip.y), centre = pose.tip.z + r;
      if (std::abs(pose.tip.x) > 2.5 || y > 5.0) continue;
      const double top = (kSmoothing + r) * std::sqrt(2.0);  // centre of the arc
      const double off =
          y < foot ? kSmoothing - std::hypot(y, top - centre) : (centre - y) / std::sqrt(2.0) - r;
      EXPECT_NEAR(off, 0.0, 1.5 * o.tolerance) << y;
    }
  // No corner is left: each turn is that of the arc over the two moves beside it.
  for (const CutRun& run : runs)
    for (std::size_t i = 1; i + 1 < run.size(); ++i) {
      if (std::abs(run[i].tip.y) > 5.0) continue;
      const Vec3 in = run[i].tip - run[i - 1].tip, out = run[i + 1].tip - run[i].tip;
      const double turn = angle_between(normalized(in), normalized(out));
      const double on_arc = std::sqrt(8.0 * kSmoothing * o.tolerance);  // longest chord
      EXPECT_LE(turn, 1.2 * on_arc / kSmoothing + 1e-3);
    }
  const auto told = [&](const std::string& w) { return w.find("up to 1.24") != std::string::npos; };
  EXPECT_TRUE(std::any_of(planned->report.warnings.begin(), planned->report.warnings.end(), told));
}

TEST(Smoothing, ARidgeStaysAsItIs) {
  const CheckedMesh ridge =
      sheet(kUpright, {-3, 3, -8, 8, 6, 32}, [](double, double y) { return 8.0 - std::abs(y); });
  PlanOptions o = smooth_options(kUpright);
  o.pattern.along = Along::kY;
  const auto smooth = plan(ridge, o, nullptr);
  o.smoothing = 0.0;
  const auto sharp = plan(ridge, o, nullptr);
  ASSERT_TRUE(smooth && sharp);
  for (const CutRun& run : dense(runs_of(smooth->path), 0.1))
    for (const Pose& pose : run) EXPECT_LE(from_runs(pose.tip, runs_of(sharp->path)), 2.0 * o.tolerance);
  EXPECT_EQ(smooth->report.warnings, sharp->report.warnings);
}

/// Steps, walls and hollows narrower than the ball, in every mode and sense.
TEST(Smoothing, RisesOnlyAndNeverGouges) {
  for (AxisMode mode : {AxisMode::kFixed, AxisMode::kLine, AxisMode::kPoint, AxisMode::kCircle})
    for (Sense sense : {Sense::kOutward, Sense::kInward}) {
      if (mode == AxisMode::kFixed && sense == Sense::kInward) continue;
      const AxisFrame axis{mode,      sense,     {1, 2, 3},
                           {1, 0, 0}, {0, 0, 1}, mode == AxisMode::kCircle ? 90.0 : 0.0};
      const CheckedMesh part = slab(axis);
      const sim::PartDistance distance_to(part.mesh);
      for (PatternKind kind : {PatternKind::kRaster, PatternKind::kSplit}) {
        PlanOptions o = smooth_options(axis);
        o.pattern.kind = kind;
        o.pattern.step_down = 1.0;
        const auto planned = plan(part, o, nullptr);
        ASSERT_TRUE(planned) << planned.error().message;
        double deepest = 0.0;
        for (const CutRun& run : dense(runs_of(planned->path), 0.2))
          for (const Pose& pose : run) {
            const Point<Part> centre = pose.tip + pose.axis * o.cutter.radius();
            deepest =
                std::max(deepest, o.cutter.radius() - distance_to.nearest(centre, o.cutter.radius()).value);
          }
        EXPECT_LE(deepest, o.tolerance);
        EXPECT_TRUE(std::any_of(
            planned->report.warnings.begin(), planned->report.warnings.end(),
            [](const std::string& w) { return w.find("smoothing_mm leaves") != std::string::npos; }));
      }
    }
}

TEST(Smoothing, NotOnLevels) {
  for (PatternKind kind : {PatternKind::kZLevel, PatternKind::kRough}) {
    PlanOptions o = smooth_options(kUpright);
    o.pattern.kind = kind;
    o.pattern.step_down = 1.0;
    const auto planned = plan(groove(), o, nullptr);
    ASSERT_FALSE(planned);
    EXPECT_NE(planned.error().message.find("points.smoothing_mm"), std::string::npos);
  }
}

}  // namespace
}  // namespace tiltfeed
