// A needle that stands over a floor, far up the tool: the ball passes below it, the tool's side does not.
// Moves of the envelope, also thinned, are held against it by the distance of two segments.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pathgen/envelope/envelope.h"
#include "pathgen/envelope/thinning.h"
#include "pathgen/surface/flat_hulls.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kBallRadius = 5.0;             ///< radius, mm
constexpr double kLength = 150.0;               ///< of the tool, mm
constexpr double kTolerance = 0.0025;           /// of the envelope and of thinning, mm
constexpr double kTurning = 0.75 * kTolerance;  /// of the side where the axis turns, mm
constexpr double kNeedleWidth = 1e-3;           ///< of the needle, mm

struct Needle {
  const char* name;
  AxisFrame frame;
  double floor, low, high;  ///< z' of the floor, and of the needle's ends
};

/// A plate square to the axis under the needle, two facets whose common edge passes far from it, and the
/// needle, which is a tetrahedron.
Mesh floor_and_needle(const Needle& c, const Deformation& map) {
  Mesh mesh;
  const auto at = [&](double x, double y, double z) { return map.unflatten({x, y, z}); };
  const Point<Part> under = at(0.0, 0.0, c.floor);
  for (const Vec3 v : {Vec3{-40, -15, 0}, Vec3{15, -15, 0}, Vec3{15, 50, 0}, Vec3{-40, 50, 0}})
    mesh.vertices.push_back(under + c.frame.t * v.x + map.b() * v.y);
  mesh.facets = {{0, 1, 2}, {0, 2, 3}};
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const Point<Part> foot = at(0.0, 0.0, c.low);
  mesh.vertices.push_back(at(0.0, 0.0, c.high));
  for (const Vec3 v : {Vec3{1, 0, 0}, Vec3{-1, 1, 0}, Vec3{-1, -1, 0}})
    mesh.vertices.push_back(foot + (c.frame.t * v.x + map.b() * v.y) * kNeedleWidth);
  mesh.facets.push_back({first, first + 1, first + 2}), mesh.facets.push_back({first, first + 2, first + 3});
  mesh.facets.push_back({first, first + 3, first + 1});
  mesh.facets.push_back({first + 1, first + 3, first + 2});
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) mesh.source.push_back(f);
  return mesh;
}

/// How deep the tool cuts into the needle on the pass's moves, mm.
double depth(const Pass& pass, Point<Part> low, Point<Part> high) {
  constexpr int kLooks = 12, kAlong = 60;
  double deepest = 0.0;
  for (std::size_t i = 0; i + 1 < pass.size(); ++i)
    for (int k = 0; k <= kLooks; ++k) {
      const double share = static_cast<double>(k) / kLooks;
      const Point<Part> centre = lerp(pass[i].centre, pass[i + 1].centre, share);
      const Point<Part> top = centre + slerp(pass[i].axis, pass[i + 1].axis, share) * kLength;
      for (int n = 0; n <= kAlong; ++n)
        deepest = std::max(
            deepest, kBallRadius - distance_to_segment(lerp(low, high, n / double{kAlong}), centre, top));
    }
  return deepest;
}

class FarUp : public testing::TestWithParam<Needle> {};

TEST_P(FarUp, TheToolsSideKeepsOff) {
  const Needle& c = GetParam();
  const Deformation map(c.frame, std::abs(c.floor));
  const Mesh mesh = floor_and_needle(c, map);
  const ToolPiece ball{.corner = kBallRadius, .outer = kBallRadius};
  const ClSurface surface(mesh, Sides::kBoth, {ball});
  const FlatIndex index(make_flat_hulls(surface, map, 0.1), map);
  EnvelopeOptions limits{kTolerance, std::sqrt(8.0 * kTurning / kLength)};
  limits.reach = kLength;
  limits.turn_tolerance = kTurning;
  Envelope envelope(surface, map, index, limits);
  const Point<Part> low = map.unflatten({0.0, 0.0, c.low}), high = map.unflatten({0.0, 0.0, c.high});
  for (const double degrees : {0.0, 90.0, 31.0})
    for (const double beside :
         {0.0, 0.3, 2.0, kBallRadius - 0.6, kBallRadius - 0.1, kBallRadius - 0.05, kBallRadius - 0.02}) {
      // Of two rows that far to the left of the needle, one where its foot is, one at its tip.
      for (const double z : {c.low, c.high}) {
        SCOPED_TRACE(std::to_string(degrees) + " degrees, " + std::to_string(beside) + " mm beside");
        const double turn = degrees * kPi / 180.0, dx = std::cos(turn), dy = std::sin(turn);
        const Deformation::Steps steps = map.steps({0.0, 0.0, z});
        const double off = beside / length(steps.y * dx - steps.x * dy);
        const LineEnvelope found = envelope.along({-dy * off - 6.0 * dx, dx * off - 6.0 * dy, dx, dy, 12.0});
        ASSERT_FALSE(found.passes.empty());
        for (const Pass& pass : found.passes) {
          EXPECT_LE(depth(pass, low, high), kTolerance + kTurning);
          EXPECT_LE(depth(thinned(pass, kTolerance, limits), low, high), 2.0 * kTolerance + kTurning);
        }
      }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Needles, FarUp,
    testing::Values(
        Needle{"fixed", {AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 0.0, 60.0, 80.0},
        Needle{"line", {AxisMode::kLine, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 6.0, 60.0, 120.0},
        Needle{"point", {AxisMode::kPoint, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 6.0, 60.0, 120.0},
        Needle{
            "circle", {AxisMode::kCircle, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 20.0}, 6.0, 60.0, 120.0},
        Needle{"into a line",
               {AxisMode::kLine, Sense::kInward, {}, {1, 0, 0}, {0, 0, 1}, 0.0},
               -160.0,
               -130.0,
               -110.0}),
    [](const testing::TestParamInfo<Needle>& tested) {
      std::string name = tested.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

}  // namespace
}  // namespace tiltfeed
