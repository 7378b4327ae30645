// Contour-parallel and spiral curves against distances from the region's border, and laid on a dome.
#include "pathgen/pattern/region_pattern.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/shapes/aside.h"
#include "tests/shapes/contour_shapes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kArc = 0.001;

double distance_from(const FlatCurve& curve, Place p) {
  double least = 1e9;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const Point<Flat> a{curve[i].x, curve[i].y, 0}, b{curve[i + 1].x, curve[i + 1].y, 0};
    if (lies_aside(p.x, a.x, b.x, least) || lies_aside(p.y, a.y, b.y, least)) continue;
    least = std::min(least, distance_to_segment(Point<Flat>{p.x, p.y, 0}, a, b));
  }
  return least;
}
FlatCurve closed(const FlatPolygon& polygon) {
  FlatCurve curve;
  for (const auto& p : polygon) curve.push_back({p[0], p[1]});
  curve.push_back(curve.front());
  return curve;
}
double signed_area(const FlatCurve& curve) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i)
    sum += curve[i].x * curve[i + 1].y - curve[i + 1].x * curve[i].y;
  return sum / 2.0;
}

const FlatPolygon kSquare{{0, 0}, {20, 0}, {20, 20}, {0, 20}};
const FlatPolygon kLetterL{{0, 0}, {30, 0}, {30, 12}, {14, 12}, {14, 31}, {0, 31}};
/// An acute arm, a neck, and a bay.
const FlatPolygon kArms{{0, 0}, {30, 3}, {12, 8}, {12, 14}, {24, 14}, {24, 30}, {9, 30}, {9, 20}, {4, 25}};
FlatPolygon circle(double x, double y, double r, int count) {
  FlatPolygon polygon;
  for (int k = 0; k < count; ++k)
    polygon.push_back({x + r * std::cos(2 * kPi * k / count), y + r * std::sin(2 * kPi * k / count)});
  return polygon;
}

RegionCurves curves_of(const std::vector<FlatPolygon>& polygons, double step, bool spiral) {
  auto result = region_curves(regions_of(polygons), {step, kArc, true, spiral});
  EXPECT_TRUE(result) << result.error().message;
  return *result;
}

TEST(RegionCurves, RingsLieAtOddHalvesOfTheStepFromTheBorder) {
  for (const FlatPolygon& polygon : {kSquare, kLetterL, circle(3, 4, 15, 100)}) {
    const RegionCurves curves = curves_of({polygon}, 1.7, false);
    std::size_t rings = 0;
    for (const auto& group : curves.groups)
      for (const FlatCurve& curve : group) {
        ++rings;
        EXPECT_LT(signed_area(curve), 0.0);
        const double depth = distance_from(closed(polygon), curve[0]);
        const double halves = depth / 0.85;
        EXPECT_NEAR(halves, std::round(halves), 0.002);
        for (const Place& p : curve) EXPECT_NEAR(distance_from(closed(polygon), p), depth, kArc + 1e-4);
      }
    EXPECT_GE(rings, 4u);
  }
}

/// Every place of the region is near a curve: half a step for at least this share, the rest near corners.
void expect_covered(const std::vector<FlatPolygon>& borders, const RegionCurves& curves, double step,
                    double share) {
  const std::vector<FlatRegion> regions = regions_of(borders);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-15.0, 32.0);
  std::size_t places = 0, near = 0;
  while (places < 1500) {
    const Place p{anywhere(random), anywhere(random)};
    if (std::none_of(regions.begin(), regions.end(), [&](const auto& r) { return in_region(r, p.x, p.y); }))
      continue;
    ++places;
    double least = 1e9;
    for (const auto& group : curves.groups)
      for (const FlatCurve& curve : group) least = std::min(least, distance_from(curve, p));
    double depth = 1e9;
    for (const FlatPolygon& border : borders) depth = std::min(depth, distance_from(closed(border), p));
    if (depth >= step / 2.0) {
      EXPECT_LT(least, kCornerReach * step) << p.x << ' ' << p.y;
    }
    near += least < step / 2.0 * 1.05 ? 1 : 0;
  }
  EXPECT_GE(static_cast<double>(near), static_cast<double>(places) * share);
}

TEST(RegionCurves, CoverTheRegion) {
  expect_covered({kSquare}, curves_of({kSquare}, 1.3, false), 1.3, 0.97);
  expect_covered({kLetterL}, curves_of({kLetterL}, 1.3, false), 1.3, 0.97);
  const FlatPolygon disc = circle(0, 0, 12, 200);
  expect_covered({kArms}, curves_of({kArms}, 1.3, false), 1.3, 0.9);
  expect_covered({disc}, curves_of({disc}, 1.7, false), 1.7, 1.0);
  const FlatPolygon hole = circle(9, 10, 4, 80);
  expect_covered({kSquare, hole}, curves_of({kSquare, hole}, 1.1, false), 1.1, 0.93);
}

TEST(RegionCurves, GoRoundHolesTheOtherWay) {
  const FlatPolygon hole = circle(10, 10, 4, 80);
  const RegionCurves curves = curves_of({kSquare, hole}, 1.0, false);
  ASSERT_FALSE(curves.groups.empty());
  ASSERT_GE(curves.groups[0].size(), 2u);
  EXPECT_NEAR(signed_area(curves.groups[0][0]), -19.0 * 19.0, 0.01);
  EXPECT_NEAR(signed_area(curves.groups[0][1]), kPi * 4.5 * 4.5, 0.3);
}

TEST(RegionCurves, SpiralIsOneCurveWhoseTurnsAreAtMostAStepApart) {
  const double step = 1.3;
  for (const FlatPolygon& polygon :
       {circle(1, 2, 12, 300), kSquare, FlatPolygon{{0, 0}, {31, 0}, {31, 13}, {0, 13}}}) {
    const RegionCurves curves = curves_of({polygon}, step, true);
    ASSERT_EQ(curves.groups.size(), 1u);
    ASSERT_EQ(curves.groups[0].size(), 1u);  // unbroken
    const FlatCurve& spiral = curves.groups[0][0];
    const FlatCurve border = closed(polygon);
    std::vector<double> depths;
    for (const Place& p : spiral) depths.push_back(distance_from(border, p));
    double last = -1.0;
    for (std::size_t i = 0; i < spiral.size(); ++i) {
      const double depth = depths[i];
      EXPECT_GT(depth, last - 0.3 * step) << i;  // inwards
      last = std::max(last, depth);
      if (i > 0) {
        EXPECT_LT(distance(spiral[i - 1], spiral[i]), step);
      }
    }
    EXPECT_NEAR(distance_from(border, spiral.front()), step / 2.0, 1e-3);
    // From each place, a place no nearer to the border by a step: either the turn before or the first ring.
    for (std::size_t i = spiral.size() / 3; i < spiral.size(); i += 7) {
      const double depth = depths[i];
      double least = 1e9;
      for (std::size_t j = 0; j + 1 < i; ++j)
        if (depths[j] < depth - 0.2 * step || depth < step)
          least = std::min(least, distance(spiral[i], spiral[j]));
      EXPECT_LT(least, step * 1.1) << i << " of " << spiral.size();
    }
    expect_covered({polygon}, curves, step * 1.05, 0.9);
  }
}

TEST(RegionCurves, SpiralGoesRoundOutwardTurnsAndBreaksWhereTheRegionDoes) {
  // A dumb-bell: one spiral outside, one in each bell.
  const FlatPolygon bells{{0, 0},   {12, 0},  {12, 4}, {20, 4}, {20, 0},  {32, 0},
                          {32, 12}, {20, 12}, {20, 8}, {12, 8}, {12, 12}, {0, 12}};
  const RegionCurves curves = curves_of({bells}, 1.2, true);
  std::size_t count = 0;
  for (const auto& group : curves.groups)
    for (const FlatCurve& curve : group) {
      double run = 0.0;
      for (std::size_t i = 0; i + 1 < curve.size(); ++i) run += distance(curve[i], curve[i + 1]);
      count += run > 10.0 ? 1 : 0;  // not the short pieces where the neck begins
    }
  EXPECT_EQ(count, 3u);
  EXPECT_EQ(curves.loops_in_spiral, 0u);
}

TEST(RegionPattern, LiesOnTheEnvelopeAllAlong) {
  Shapes shapes;
  shapes.bead(0.0, 0.0, 0.0, 8.0, 0.0, false, 90);
  shapes.floor(-15, -15, 15, 15, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  for (PatternKind kind : {PatternKind::kContour, PatternKind::kSpiral}) {
    ContourOptions options;
    options.envelope = {0.0025, 0.03}, options.pattern.kind = kind, options.pattern.side_step = 2.0;
    const auto result = region_pattern(*field, options, {});
    ASSERT_TRUE(result) << result.error().message;
    ASSERT_EQ(result->groups.size(), 1u);
    EXPECT_EQ(result->groups[0].size(), kind == PatternKind::kSpiral ? 1u : 9u);
    // The silhouette is the floor's border grown by the ball, half a step inside it the first ring.
    double widest = 0.0;
    for (const Pass& pass : result->groups[0]) {
      EXPECT_EQ(is_closed(pass), kind == PatternKind::kContour);
      for (const EnvelopePoint& p : pass) widest = std::max(widest, p.flat.x);
      for (std::size_t i = 0; i + 1 < pass.size(); i += 1 + pass.size() / 15)
        EXPECT_NEAR(let_down(shapes.mesh, field->deformation.axis_line(pass[i].flat.x, pass[i].flat.y),
                             kBallRadius, -3.0),
                    pass[i].flat.z, 0.01);
    }
    EXPECT_NEAR(widest, 16.0, 0.05);
  }
}

TEST(RegionPattern, TakesTheBoundaryAndRefusesWhatIsEmpty) {
  Shapes shapes;
  shapes.floor(-15, -15, 15, 15, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  ContourOptions options;
  options.envelope = {0.0025, 0.03}, options.pattern.side_step = 1.0;
  options.boundary = {{-10, -5}, {-10, 6}, {3, 6}, {3, -5}};
  auto result = region_pattern(*field, options, {});
  ASSERT_TRUE(result);
  for (const Pass& pass : result->groups[0])
    for (const EnvelopePoint& p : pass) EXPECT_TRUE(in_polygon(options.boundary, p.flat.x, p.flat.y));
  options.boundary = {{-10, -5}, {-10, -4.5}, {3, -4.5}, {3, -5}};
  result = region_pattern(*field, options, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::kUnreachable);
  options.boundary = {{60, 60}, {70, 60}, {70, 70}};
  EXPECT_FALSE(region_pattern(*field, options, {}));
}

}  // namespace
}  // namespace tiltfeed
