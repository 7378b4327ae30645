// Rows that close round a part: past the seam of the flat space neighbours are no further apart than
// elsewhere.
#include <gtest/gtest.h>

#include <set>

#include "kinematics/basics/units.h"
#include "pathgen/options/side_step.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kRadius = 20.0, kBall = 4.0;

/// A cylinder round z, `aside` from the line of the axis field, whose seam looks to `seam` (rad).
struct Shaft {
  double aside, seam;
  CheckedMesh part = turned({{0, 10}, {kRadius, 10}, {kRadius, -10}, {0, -10}}, 360);

  AxisFrame frame() const {
    const Vec3 n{-std::cos(seam), -std::sin(seam), 0};
    return {AxisMode::kLine, Sense::kOutward, {aside, 0, 0}, {0, 0, 1}, n, 0.0};
  }
  PlanOptions options(StepMeasure measure, double step) const {
    PlanOptions o = options_with(frame());
    o.cutter = {2.0 * kBall, 150.0, 60.0};
    o.pattern.along = Along::kX;
    o.pattern.measure = measure;
    o.pattern.side_step = measure == StepMeasure::kScallop ? 0.0 : step;
    o.pattern.scallop = kBall - std::sqrt(kBall * kBall - step * step / 4.0);
    o.containment.first = {-8.0, 8.0};
    o.links.join_distance = 2.0 * step;
    return o;
  }
};

/// Where rows touch the cylinder round z at half its height, as angles from `seam`, each once.
std::vector<double> rows_round(const ToolPath& path, double seam) {
  std::set<double> angles;
  for (std::size_t i = 1; i < path.moves.size(); ++i) {
    const Pose &a = path.moves[i - 1].pose, &b = path.moves[i].pose;
    if (path.moves[i].kind != MoveKind::kCut || !((a.tip.z < 0.0) != (b.tip.z < 0.0))) continue;
    const Point<Part> centre = lerp(a.tip, b.tip, a.tip.z / (a.tip.z - b.tip.z)) + a.axis * kBall;
    const double angle = std::atan2(centre.y, centre.x) - seam;
    angles.insert(angle - 2.0 * kPi * std::floor(angle / (2.0 * kPi)));
  }
  return {angles.begin(), angles.end()};
}

TEST(Seam, RowsCloseRoundTheCircleForEveryMeasure) {
  for (const StepMeasure measure : {StepMeasure::kFlat, StepMeasure::kSurface, StepMeasure::kScallop})
    for (const double aside : {0.0, 9.0, -9.0})
      for (const double seam : {0.0, 2.1, kPi})
        for (const double step : {0.9, 2.7}) {
          // Flat steps are those of a cylinder of the mean radius: on the part only where the line is its
          // axis.
          if (measure == StepMeasure::kFlat && aside != 0.0) continue;
          const Shaft shaft{aside, seam};
          const auto planned = plan(shaft.part, shaft.options(measure, step), nullptr);
          ASSERT_TRUE(planned) << planned.error().message;
          const std::vector<double> rows = rows_round(planned->path, seam);
          ASSERT_GT(rows.size(), 10u);
          double widest = rows.front() + 2.0 * kPi - rows.back(), least = widest;
          for (std::size_t i = 1; i < rows.size(); ++i) {
            widest = std::max(widest, rows[i] - rows[i - 1]);
            least = std::min(least, rows[i] - rows[i - 1]);
          }
          EXPECT_LE(widest * kRadius, step * 1.001)
              << "measure " << static_cast<int>(measure) << ", aside " << aside << ", seam " << seam;
          EXPECT_GT(least * kRadius, 0.1 * step) << "a row twice";
        }
}

TEST(Seam, TheStepThatIsAskedIsTheSmallerOfScallopAndSideStep) {
  const Shaft shaft{0.0, 0.0};
  PlanOptions o = shaft.options(StepMeasure::kScallop, 1.8);
  EXPECT_NEAR(asked_step(o), 1.8, 1e-12);
  o.pattern.side_step = 1.0;
  EXPECT_EQ(asked_step(o), 1.0);
  o.pattern.measure = StepMeasure::kSurface;
  EXPECT_EQ(asked_step(o), 1.0);
}

}  // namespace
}  // namespace tiltfeed
