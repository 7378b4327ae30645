// Layers for roughing and the trimming of passes, against closed forms and the ball let down by search.
#include "pathgen/pattern/rough_layers.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/shapes/contour_shapes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr EnvelopeOptions kLimits{0.0025, 0.03};

Shapes dome_and_step() {
  Shapes shapes;
  shapes.bead(0.0, 0.0, 0.0, 8.0, 0.0, false, 90);
  shapes.floor(-20, -20, 30, 20, 0.0);
  shapes.box(15, -20, 30, 20, 0.0, 5.0);
  return shapes;
}

double run_of(const FlatLine& line, Point<Flat> f) {
  return (f.x - line.x) * line.dx + (f.y - line.y) * line.dy;
}

/// z' of the passes at a run; nothing where none is.
std::optional<double> height_at(const std::vector<Pass>& passes, const FlatLine& line, double run) {
  for (const Pass& pass : passes)
    for (std::size_t i = 0; i + 1 < pass.size(); ++i) {
      const double a = run_of(line, pass[i].flat), b = run_of(line, pass[i + 1].flat);
      if (run < a || run > b || a == b) continue;
      return pass[i].flat.z + (pass[i + 1].flat.z - pass[i].flat.z) * (run - a) / (b - a);
    }
  return std::nullopt;
}

TEST(RoughLayers, EachIsTheHigherOfFloorAndEnvelopeWhereThatIsNotCutYet) {
  const Shapes shapes = dome_and_step();
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  Heights heights(*field, kLimits);
  const FlatLine line{-18.0, 1.3, 1.0, 0.0, 46.0};
  const auto passes = heights.envelope().along(line).passes;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(0.1, 45.9);
  std::size_t present = 0, absent = 0;
  for (const RoughLayer& layer :
       {RoughLayer{11.0, 8.0, 0.0025, 0.03, false}, RoughLayer{8.0, 5.0, 0.0025, 0.03, false},
        RoughLayer{5.0, 2.0, 0.0025, 0.03, false}}) {
    const auto clipped = layer_passes(passes, line, layer, heights);
    for (const Pass& pass : clipped)
      for (std::size_t i = 0; i + 1 < pass.size(); ++i)
        EXPECT_LE(run_of(line, pass[i].flat), run_of(line, pass[i + 1].flat));
    for (int i = 0; i < 60; ++i) {
      const double run = anywhere(random);
      const AxisLine axis = field->deformation.axis_line(line.x_at(run), line.y_at(run));
      const double part = let_down(shapes.mesh, axis, kBallRadius, 0.0);
      // A wall is a jump: not next to it.
      const AxisLine beside = field->deformation.axis_line(line.x_at(run + 0.01), line.y_at(run));
      if (std::abs(let_down(shapes.mesh, beside, kBallRadius, 0.0) - part) > 0.2) continue;
      const auto found = height_at(clipped, line, run);
      if (part > layer.upper + 0.02) {
        EXPECT_FALSE(found) << run;
        ++absent;
      } else if (part < layer.upper - 0.02) {
        ASSERT_TRUE(found) << run << " layer " << layer.lower;
        EXPECT_NEAR(*found, std::max(part, layer.lower), 0.012) << run;
        ++present;
      }
    }
  }
  EXPECT_GT(present, 60u);
  EXPECT_GT(absent, 20u);
}

TEST(RoughLayers, EndAtTheWallExactlyAndNeverInIt) {
  const Shapes shapes = dome_and_step();
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  Heights heights(*field, kLimits);
  const FlatLine line{-18.0, 12.0, 1.0, 0.0, 46.0};
  const auto clipped =
      layer_passes(heights.envelope().along(line).passes, line, {4.5, 3.0, 0.0025, 0.03, false}, heights);
  ASSERT_EQ(clipped.size(), 1u);
  EXPECT_NEAR(clipped[0].back().flat.x, 13.0, kTrimStep);  // the wall less the ball
  EXPECT_LE(clipped[0].back().flat.x, 13.0);
  for (const EnvelopePoint& p : clipped[0]) EXPECT_EQ(p.flat.z, 3.0);
}

TEST(RoughLayers, LeaveTheFloorAndEndOnARampExactly) {
  Shapes shapes;
  shapes.quad({0, -10, 0}, {30, -10, 15}, {30, 10, 15}, {0, 10, 0});
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  Heights heights(*field, kLimits);
  const FlatLine line{1.0, 0.0, 1.0, 0.0, 28.0};
  const auto clipped =
      layer_passes(heights.envelope().along(line).passes, line, {9.0, 6.0, 0.0025, 0.03, false}, heights);
  ASSERT_EQ(clipped.size(), 1u);
  // The ramp's plane raised by the ball: z = x / 2 + R / cos.
  const auto ramp_x = [](double z) { return 2.0 * (z - kBallRadius * std::sqrt(1.25)); };
  EXPECT_NEAR(clipped[0].back().flat.x, ramp_x(9.0), kTrimStep);
  EXPECT_LE(clipped[0].back().flat.z, 9.0);
  double leaves = 0.0;
  for (const EnvelopePoint& p : clipped[0])
    if (p.flat.z <= 6.0) leaves = std::max(leaves, p.flat.x);
  EXPECT_NEAR(leaves, ramp_x(6.0), kTrimStep);
}

TEST(RoughLayers, GoOnOverGapsAtTheFloorWhenAsked) {
  Shapes shapes;  // two plates with nothing between
  shapes.floor(0, 0, 10, 10, 0.0), shapes.floor(30, 0, 40, 10, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  Heights heights(*field, kLimits);
  const FlatLine line{-5.0, 5.0, 1.0, 0.0, 50.0};
  const auto passes = heights.envelope().along(line).passes;
  EXPECT_EQ(layer_passes(passes, line, {9.0, 5.0, 0.0025, 0.03, false}, heights).size(), 2u);
  const auto over = layer_passes(passes, line, {9.0, 5.0, 0.0025, 0.03, true}, heights);
  ASSERT_EQ(over.size(), 1u);
  EXPECT_NEAR(over[0].front().flat.x, -5.0, 1e-6);
  EXPECT_NEAR(over[0].back().flat.x, 45.0, 1e-6);
}

TEST(RoughLayers, FloorsFollowTheAxisRoundThePoint) {
  AxisFrame frame;
  frame.mode = AxisMode::kPoint, frame.n = {1, 0, 0}, frame.t = {0, 1, 0};
  Shapes shapes;
  std::vector<std::array<double, 2>> arc;
  for (int k = -15; k <= 15; ++k) arc.push_back({20.0 * std::cos(0.05 * k), 20.0 * std::sin(0.05 * k)});
  shapes.revolve(0, 0, arc, 120);
  const auto field = field_over(shapes.mesh, frame, 2.0 * kBallRadius, 22.0);
  Heights heights(*field, kLimits);
  const FlatLine line{-30.0, 2.0, 1.0, 0.0, 60.0};
  const auto clipped =
      layer_passes(heights.envelope().along(line).passes, line, {30.0, 26.0, 0.0025, 0.03, false}, heights);
  ASSERT_EQ(clipped.size(), 1u);
  const Pass& pass = clipped[0];
  for (std::size_t i = 0; i + 1 < pass.size(); ++i) {
    EXPECT_NEAR(length(pass[i].centre - Point<Part>{}), 26.0, 1e-9);
    EXPECT_GT(length(lerp(pass[i].centre, pass[i + 1].centre, 0.5) - Point<Part>{}), 26.0 - 0.0026);
    EXPECT_LE(angle_between(pass[i].axis, pass[i + 1].axis), 0.0301);
  }
}

/// About a circle of radius 5 the column at Phi holds what lies up to 5 / -cos(Phi) from the circle; beyond,
/// past the axis of Theta, a block stands that this column does not see.
TEST(RoughLayers, FloorsEndAtTheAxisOfTheta) {
  Shapes shapes;
  shapes.box(-4.0, -1.0, -3.0, 1.0, -1.0, 1.0);
  for (const Sense sense : {Sense::kInward, Sense::kOutward}) {
    const AxisFrame frame{AxisMode::kCircle, sense, {}, {0, 1, 0}, {1, 0, 0}, 5.0};
    const auto field = field_over(shapes.mesh, frame, 0.6, 4.0);
    const Deformation& map = field->deformation;
    Heights heights(*field, kLimits);
    const double rho = 8.0, turn = map.period_y(), s = map.s();
    const RoughLayer layer{s * rho + 0.5, s * rho, 0.0025, 0.03, true};
    const double limit = std::acos((kLeastAxisDistance - 5.0) / rho) * map.scale_y();
    // Along Phi all round; across it, beside the limit within its column and beyond.
    const FlatLine along{0.1, -0.5 * turn, 0.0, 1.0, turn}, within{-1.0, limit - 0.01, 1.0, 0.0, 2.0},
        beyond{-1.0, limit + 0.01, 1.0, 0.0, 2.0};
    const auto floors = layer_passes(heights.envelope().along(along).passes, along, layer, heights);
    ASSERT_EQ(floors.size(), 1u);
    EXPECT_NEAR(floors[0].front().flat.y, -limit, kTrimStep);
    EXPECT_NEAR(floors[0].back().flat.y, limit, kTrimStep);
    for (const EnvelopePoint& p : floors[0])
      EXPECT_LT(distance(map.unflatten(map.flatten(p.centre)), p.centre) +
                    std::abs(map.flatten(p.centre).y - p.flat.y),
                1e-6);
    EXPECT_EQ(layer_passes({}, within, layer, heights).size(), 1u);
    EXPECT_TRUE(layer_passes({}, beyond, layer, heights).empty());
  }
}

TEST(RoughLayers, AllLayersTogetherComeDownToThePart) {
  const Shapes shapes = dome_and_step();
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  std::vector<FlatLine> lines;
  for (int k = 0; k < 19; ++k) lines.push_back({-18.0, -18.0 + 2.0 * k, 1.0, 0.0, 46.0});
  ContourOptions options;
  options.envelope = kLimits, options.pattern.step_down = 1.7, options.height.low = kBallRadius;
  const auto result = rough_layers(*field, lines, 12.0, false, options, {});
  ASSERT_TRUE(result) << result.error().message;
  double last = 12.0;
  for (const auto& group : result->groups) {
    double low = 1e9;
    for (const Pass& pass : group)
      for (const EnvelopePoint& p : pass) low = std::min(low, p.flat.z);
    EXPECT_LE(low, last + 1e-9);  // layers never rise
    last = std::max(low, kBallRadius);
    for (const Pass& pass : group)
      for (std::size_t i = 0; i < pass.size(); i += 1 + pass.size() / 4)
        EXPECT_LE(let_down(shapes.mesh, field->deformation.axis_line(pass[i].flat.x, pass[i].flat.y),
                           kBallRadius, pass[i].flat.z - 1.0),
                  pass[i].flat.z + 0.01);
  }
  EXPECT_NEAR(last, kBallRadius, 1e-9);
}

// (pattern.h, property 3)
TEST(PassTrim, SplitBySlopeCoversTheSphereWithTheOverlapTwice) {
  Shapes shapes;
  shapes.bead(0.0, 0.0, 0.0, 10.0, 0.0, false, 240);
  shapes.floor(-20, -20, 20, 20, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  Heights heights(*field, kLimits);
  const FlatLine line{-18.0, 0.0, 1.0, 0.0, 36.0};
  const auto passes = heights.envelope().along(line).passes;
  const Angle split = Angle::from_degrees(50.0);
  const auto shallow = shallow_of(passes, field->deformation, split, 0.5);
  const auto steep = steep_of(passes, field->deformation, split, 0.5);
  // On the sphere of 12 the slope is 50 degrees at r = 12 sin 50; the arc goes on for the overlap.
  const double over = 0.5 / 12.0, at = split.radians();
  ASSERT_EQ(shallow.size(), 3u);  // floor, top, floor
  // Slopes change from facet to facet, some 2.8 degrees apart.
  EXPECT_NEAR(shallow[1].back().flat.x, 12.0 * std::sin(at + over), 0.45);
  ASSERT_EQ(steep.size(), 2u);
  EXPECT_NEAR(steep[1].front().flat.x, 12.0 * std::sin(at - over), 0.45);
  EXPECT_NEAR(shallow[1].back().flat.x - steep[1].front().flat.x,
              12.0 * (std::sin(at + over) - std::sin(at - over)), 0.02);
}

TEST(PassTrim, PolygonCutsClosedPassesExactly) {
  Pass ring;
  for (int k = 0; k <= 720; ++k) {
    EnvelopePoint p;
    const double turn = 2.0 * kPi * (k % 720) / 720;
    p.flat = {5.0 * std::cos(turn), 5.0 * std::sin(turn), 1.0};
    p.centre = {p.flat.x, p.flat.y, p.flat.z}, p.axis = {0, 0, 1}, p.normal = {0, 0, 1};
    ring.push_back(p);
  }
  const Deformation map({}, 1.0);
  // Two strips thinner than a move, and the right half.
  const auto half = inside_polygon({ring}, map, {{0.003, -9}, {9, -9}, {9, 9}, {0.003, 9}});
  ASSERT_EQ(half.size(), 1u);  // in one piece over the ring's start
  EXPECT_NEAR(half[0].front().flat.x, 0.003, kTrimStep);
  EXPECT_NEAR(half[0].back().flat.x, 0.003, kTrimStep);
  EXPECT_LT(half[0].front().flat.y, 0.0);
  const auto sliver = inside_polygon({ring}, map, {{0.01, -9}, {0.012, -9}, {0.012, 9}, {0.01, 9}});
  ASSERT_EQ(sliver.size(), 2u);
  EXPECT_EQ(inside_polygon({ring}, map, {}).size(), 1u);
  EXPECT_TRUE(inside_polygon({ring}, map, {{20, 20}, {21, 20}, {21, 21}}).empty());
}

}  // namespace
}  // namespace tiltfeed
