// Contours at constant z' where the tool axis turns: about a point and about a line, against closed forms in
// part space and against the ball let down on every facet by search.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/judges/contour_proof.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

TEST(ZLevel, PointModeGivesTheSpheresCirclesInPartSpace) {
  // A dome on a large ball; the axes run through the ball's centre.
  const double big = 30.0;
  AxisFrame frame;
  frame.mode = AxisMode::kPoint, frame.n = {1, 0, 0}, frame.t = {0, 1, 0};
  Shapes shapes;
  shapes.revolve(
      0, 0,
      [&] {
        std::vector<std::array<double, 2>> arc;
        for (int k = -20; k <= 20; ++k) {
          const double turn = 0.05 * k;
          arc.push_back({big * std::cos(turn), big * std::sin(turn)});
        }
        return arc;
      }(),
      240);
  Shapes dome;
  dome.bead(0.0, 0.0, 0.0, 6.0, 0.0, false, 120);
  for (const auto& f : dome.mesh.facets) {  // its pole to +x
    const auto turned = [&](std::uint32_t v) {
      const Point<Part> p = dome.mesh.vertices[v];
      return Point<Part>{big + p.z, p.x, p.y};
    };
    shapes.facet(turned(f[0]), turned(f[1]), turned(f[2]));
  }
  const auto field = field_over(shapes.mesh, frame, 2.0 * kBallRadius, big + kBallRadius);
  ContourOptions options = options_for(1.0, 0.8);
  options.height = {big + kBallRadius + 0.4, big + kBallRadius + 5.4};
  const Contours contours = contours_of(*field, options);
  ASSERT_GE(pass_count(contours), 5u);
  EXPECT_TRUE(contours.warnings.empty());
  const Point<Part> centre{big, 0, 0};
  each_pass(contours, [&](const Pass& pass) {
    EXPECT_TRUE(is_closed(pass));
    const double rho = pass[0].flat.z;
    for (const EnvelopePoint& p : pass) {
      EXPECT_NEAR(length(p.centre - Point<Part>{}), rho, 1e-6);
      // On the dome grown by the ball, but where the equator of the dome is seen past.
      const double cosine = (rho * rho + big * big - 64.0) / (2.0 * rho * big);
      EXPECT_NEAR(angle_between(p.centre - Point<Part>{}, Vec3{1, 0, 0}) * rho, std::acos(cosine) * rho,
                  0.03);
    }
    EXPECT_LE(distance(pass[0].centre, centre), 8.05);
  });
  expect_on_the_border(shapes.mesh, *field, contours, 40);
}

TEST(ZLevel, GoesAllRoundALineOverTheSeam) {
  // A collar on a shaft; the axes run through the shaft's middle.
  AxisFrame frame;
  frame.mode = AxisMode::kLine, frame.t = {0, 0, 1}, frame.n = {1, 0, 0};
  Shapes shapes;
  shapes.revolve(0, 0, {{10, -15}, {10, -2}, {13, -2}, {13, 2}, {10, 2}, {10, 15}}, 360);
  const auto field = field_over(shapes.mesh, frame, 2.0 * kBallRadius, 12.0);
  ContourOptions options = options_for(1.0, 0.9);
  options.height = {12.5, 13.5};
  const Contours contours = contours_of(*field, options);
  ASSERT_EQ(pass_count(contours), 2u);
  EXPECT_TRUE(contours.warnings.empty());
  const double turn = field->deformation.period_y();
  each_pass(contours, [&](const Pass& pass) {
    EXPECT_TRUE(is_closed(pass));
    const double side = pass[0].flat.x > 0.0 ? 1.0 : -1.0;
    double gone = 0.0;
    for (std::size_t i = 0; i < pass.size(); ++i) {
      EXPECT_NEAR(pass[i].flat.x, side * (2.0 + kBallRadius), kTolerance);  // the wall less the ball
      EXPECT_LE(std::abs(pass[i].flat.y), turn / 2.0 + 1e-9);
      if (i > 0) gone += std::remainder(pass[i].flat.y - pass[i - 1].flat.y, turn);
    }
    EXPECT_NEAR(gone, -side * turn, 1e-6);  // once round, the collar on the right
  });
  expect_on_the_border(shapes.mesh, *field, contours, 40);
}

TEST(ZLevel, AWindowAtASeamReachesOverIt) {
  // A shaft with a post beside the seam: the ball goes round its corner there.
  AxisFrame frame;
  frame.mode = AxisMode::kLine, frame.t = {0, 0, 1}, frame.n = {1, 0, 0};
  Shapes shapes;
  shapes.revolve(0, 0, {{10, -15}, {10, 15}}, 180);
  shapes.box(-16.0, 0.5, -9.0, 2.0, -1.0, 1.0);
  const auto field = field_over(shapes.mesh, frame, 2.0 * kBallRadius, 12.0);
  ContourOptions options = options_for(3.0, 2.0);
  options.height = {12.5, 15.0};
  std::vector<Contours> all;
  for (const double spacing : {2.0, 1.3, 0.7}) {
    options.pattern.side_step = spacing;
    all.push_back(contours_of(*field, options));
  }
  options.pattern.side_step = 2.0;
  const double half = field->deformation.period_y() / 2.0;
  for (const auto& [low, high] : {std::pair{-half, half}, {-half, 5.0 - half}, {half - 3.0, half}}) {
    options.window = FlatBounds{-20.0, 20.0, low, high};
    const Contours some = contours_of(*field, options);
    EXPECT_GT(expect_same_in(*options.window, some, all), 20u) << low;
    EXPECT_TRUE(some.warnings.empty());
  }
}

/// Inside a ball-shaped cavity, the tool pointing at its middle: a spike that comes within a tool radius of
/// the middle shuts every column, the one asked for first and all after it.
TEST(ZLevel, ColumnsWhoseEndThePartCoversAreShutOneAndAll) {
  Shapes shapes;
  const Point<Part> tip{0.0, 0.0, 0.5}, a{1.0, 0.0, 1.5}, b{-0.5, 0.8, 1.5}, c{-0.5, -0.8, 1.5};
  shapes.facet(tip, b, a), shapes.facet(tip, c, b), shapes.facet(tip, a, c), shapes.facet(a, b, c);
  const AxisFrame frame{AxisMode::kPoint, Sense::kInward, {}, {1, 0, 0}, {0, 0, 1}, 0.0};
  const auto field = field_over(shapes.mesh, frame, 2.0 * kBallRadius, 10.0);
  Heights heights(*field, options_for(1.0, 1.0).envelope);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x(-30.0, 30.0), y(-14.0, 14.0);
  for (int i = 0; i < 200; ++i) EXPECT_EQ(heights.at({x(random), y(random)}), kShut) << "place " << i;
}

/// Beyond the axis of Theta a level is other columns' matter: the tool would stand there the other way round.
/// A closed form: places nearer than kLeastAxisDistance to that axis, or of other flat coordinates than those
/// that they were made from.
TEST(ZLevel, LaysNothingBeyondTheAxisOfThetaInInsideWork) {
  Shapes shapes;  // a block between the axis of Theta and the circle, and one beyond that axis
  shapes.box(3.0, -1.0, 4.0, 1.0, -1.0, 1.0), shapes.box(-4.0, -1.0, -3.0, 1.0, -1.0, 1.0);
  const AxisFrame frame{AxisMode::kCircle, Sense::kInward, {}, {0, 1, 0}, {1, 0, 0}, 5.0};
  const auto field = field_over(shapes.mesh, frame, 0.6, 3.0);
  ContourOptions options = options_for(0.5, 0.25);
  options.height = {-9.0, -1.0};
  const Contours contours = contours_of(*field, options);
  std::size_t points = 0;
  each_pass(contours, [&](const Pass& pass) {
    for (const EnvelopePoint& p : pass) {
      const Point<Flat> back = field->deformation.flatten(p.centre);
      EXPECT_GE(std::hypot(p.centre.x, p.centre.y), 0.0999);
      EXPECT_NEAR(std::remainder(back.x - p.flat.x, field->deformation.period_x()), 0.0, 1e-6);
      EXPECT_NEAR(std::remainder(back.y - p.flat.y, field->deformation.period_y()), 0.0, 1e-6);
      ++points;
    }
  });
  EXPECT_GT(points, 200u);
}

}  // namespace
}  // namespace tiltfeed
