// Straight moves over a plate through which a pyramid's tip pokes: between two points on the plate nothing
// but the tip's sphere tells that there is more. Heights in closed form.
#include "pathgen/envelope/straight_moves.h"
#include "pathgen/envelope/envelope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pathgen/surface/flat_hulls.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kBall = 5.0;  ///< radius, mm
constexpr double kTip = 0.3;   ///< over the plate, which lies at z = 0; mm

/// A level ridge, or a tip where both ends are one.
struct Ridge {
  Point<Part> from, to;
  /// Height of the ball's centre on it, over a place at most kBall away; else 0.
  double height(double x, double y) const {
    const double away = distance_to_segment(Point<Part>{x, y, 0.0}, {from.x, from.y, 0.0}, {to.x, to.y, 0.0});
    return away < kBall ? from.z + std::sqrt(kBall * kBall - away * away) : 0.0;
  }
};

/// Two facets of plate, each of which goes on under the other shell, and a steep roof.
Mesh plate_and_roof(const Ridge& ridge) {
  Mesh mesh;
  mesh.vertices = {{-30, -30, 0}, {30, -30, 0}, {30, 30, 0}, {-30, 30, 0}};
  mesh.facets = {{0, 1, 2}, {0, 2, 3}};
  const bool tip = ridge.from == ridge.to;
  const Vec3 along = tip ? Vec3{2, 0, 0} : normalized(ridge.to - ridge.from) * 2.0;
  const Vec3 across = cross({0, 0, 1}, along), down{0, 0, -8.0};
  const std::uint32_t a = 4, b = tip ? a : 5, base = b + 1;  // corners of the base, counter-clockwise
  mesh.vertices.push_back(ridge.from);
  if (!tip) mesh.vertices.push_back(ridge.to);
  mesh.vertices.push_back(ridge.from - along - across + down);
  mesh.vertices.push_back(ridge.to + along - across + down);
  mesh.vertices.push_back(ridge.to + along + across + down);
  mesh.vertices.push_back(ridge.from - along + across + down);
  mesh.facets.push_back({base, base + 1, b}), mesh.facets.push_back({base + 1, base + 2, b});
  mesh.facets.push_back({base + 2, base + 3, a}), mesh.facets.push_back({base + 3, base, a});
  if (!tip) mesh.facets.push_back({base, b, a}), mesh.facets.push_back({base + 2, a, b});
  mesh.facets.push_back({base, base + 3, base + 2}), mesh.facets.push_back({base, base + 2, base + 1});
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) mesh.source.push_back(f);
  return mesh;
}

class StraightMovesTest : public testing::TestWithParam<Ridge> {};

// (envelope.h, property 2)
TEST_P(StraightMovesTest, KeepOffWhatPokesThroughAPlane) {
  const Ridge ridge = GetParam();
  const Mesh mesh = plate_and_roof(ridge);
  const ToolPiece ball{.corner = kBall, .outer = kBall};
  const ClSurface surface(mesh, Sides::kOutward, {ball});
  const Deformation map({AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 1.0);
  const FlatIndex index(make_flat_hulls(surface, map, 0.1), map);
  const EnvelopeOptions limits{0.0025, 0.02};
  Envelope envelope(surface, map, index, limits);
  const double reach =
      std::sqrt(kBall * kBall - (kBall - kTip) * (kBall - kTip));  // of the ridge, on the plate
  for (const double beside : {0.0, 0.4 * reach, 0.8 * reach, 0.99 * reach, 1.01 * reach, 1.4 * reach}) {
    SCOPED_TRACE("row " + std::to_string(beside) + " mm beside the ridge");
    const FlatLine row{-5.0, -5.0 + beside, 1.0, 0.0, 25.0};
    const LineEnvelope found = envelope.along(row);
    ASSERT_EQ(found.passes.size(), 1U);
    const Pass& pass = found.passes[0];
    double lowest = 0.0, highest = 0.0;
    for (std::size_t i = 0; i + 1 < pass.size(); ++i)
      for (double share = 0.0; share <= 1.0; share += 0.02) {
        const Point<Part> p = lerp(pass[i].centre, pass[i + 1].centre, share);
        const double off = p.z - std::max(kBall, ridge.height(p.x, p.y));
        lowest = std::min(lowest, off), highest = std::max(highest, off);
      }
    EXPECT_GE(lowest, -1.1 * limits.tolerance);
    EXPECT_LE(highest, 1.1 * limits.tolerance);
    // What stays below the plate's surface is not followed; a ridge is taken as endless.
    if (beside > reach && ridge.from == ridge.to) {
      EXPECT_LE(pass.size(), 20U);
    }
  }
}

constexpr double kFlatEnd = 4.0;  ///< radius, mm
constexpr double kRise = 0.5;     ///< of a plate that climbs along x
constexpr double kThin = 0.01;    ///< half the width of pillars that stand on it, mm

/// A plate that climbs, and thin pillars with level tops through it.
Mesh plate_and_pillars(const std::vector<Point<Part>>& tops) {
  Mesh mesh;
  mesh.vertices = {{-60, -60, -30}, {60, -60, 30}, {60, 60, 30}, {-60, 60, -30}};
  mesh.facets = {{0, 1, 2}, {0, 2, 3}};
  for (const Point<Part>& top : tops) {
    const auto v = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const double down : {0.0, -5.0})
      for (const Vec3 aside : {Vec3{-1, -1, 0}, Vec3{1, -1, 0}, Vec3{1, 1, 0}, Vec3{-1, 1, 0}})
        mesh.vertices.push_back(top + aside * kThin + Vec3{0, 0, down});
    mesh.facets.push_back({v, v + 1, v + 2}), mesh.facets.push_back({v, v + 2, v + 3});
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t next = (k + 1) % 4;
      mesh.facets.push_back({v + k, v + 4 + next, v + next}),
          mesh.facets.push_back({v + k, v + 4 + k, v + 4 + next});
    }
  }
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) mesh.source.push_back(f);
  return mesh;
}

/// A flat end goes up the plate; a pillar's top comes under its bottom from one moment to the next and, a
/// little later, is passed by the plate at the rim.
// (envelope.h, property 2)
TEST(StraightMoves, AFlatEndMeetsWhatComesUnderItAllAtOnce) {
  std::vector<Point<Part>> tops;
  for (int i = 0; i < 90; ++i) {
    const double x = -12.0 + 0.31 * i, y = std::fmod(1.7 * i, 5.0) - 2.5,
                 front = std::sqrt(kFlatEnd * kFlatEnd - y * y);
    // Over the plate at the rim by a little when it comes in.
    tops.push_back({x, y, kRise * (x - front + kFlatEnd) + 0.01 + 0.005 * (i % 7)});
  }
  const Mesh mesh = plate_and_pillars(tops);
  const ClSurface surface(mesh, Sides::kOutward, {ToolPiece{.flat = kFlatEnd, .outer = kFlatEnd}});
  const Deformation map({AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 1.0);
  const FlatIndex index(make_flat_hulls(surface, map, 0.1), map);
  const EnvelopeOptions limits{0.0025, 0.02};
  Envelope envelope(surface, map, index, limits);
  double deepest = 0.0;
  for (double beside = -0.9; beside < 1.0; beside += 0.2) {
    const LineEnvelope found = envelope.along({-20.0, beside, 1.0, 0.0, 30.0});
    ASSERT_EQ(found.passes.size(), 1U);
    const Pass& pass = found.passes[0];
    for (std::size_t i = 0; i + 1 < pass.size(); ++i)
      for (double share = 0.05; share < 1.0; share += 0.05) {
        const Point<Part> p = lerp(pass[i].centre, pass[i + 1].centre, share);
        for (const Point<Part>& top : tops) {
          const double x = std::max(0.0, std::abs(top.x - p.x) - kThin),
                       y = std::max(0.0, std::abs(top.y - p.y) - kThin);
          deepest = std::max(deepest, std::min(top.z - p.z, kFlatEnd - std::hypot(x, y)));
        }
      }
  }
  EXPECT_LE(deepest, 1.05 * limits.tolerance);
}

/// A steep wall of narrow strips, of which every third is missing: the rim of a flat end goes up it and sinks
/// into the gaps, down to the strip below. The strips' planes are one, so the ends of a move over a gap tell
/// nothing of it.
// (envelope.h, property 2)
TEST(StraightMoves, ASharpRimSinksIntoTheGapsOfASteepWall) {
  constexpr double kSteepRise = 3.2, kStrip = 0.01;
  constexpr int kStrips = 40;
  const auto at = [](int k, double y) { return Point<Part>{k * kStrip, y, kSteepRise * k * kStrip}; };
  Mesh mesh;
  std::vector<std::array<Point<Part>, 2>> profile;  // of the rim's front, in the plane y = 0
  for (int k = 0; k <= kStrips; ++k)
    mesh.vertices.push_back(at(k, -9.0)), mesh.vertices.push_back(at(k, 9.0));
  for (int k = 0; k < kStrips; ++k) {
    const Point<Part> low = at(k, 0.0), high = at(k + 1, 0.0), foot{high.x, 0.0, low.z};
    if (k % 3 == 1) {
      profile.push_back({low, foot}), profile.push_back({foot, high});
      continue;
    }
    profile.push_back({low, high});
    const auto v = static_cast<std::uint32_t>(2 * k);
    mesh.facets.push_back({v, v + 2, v + 3}), mesh.facets.push_back({v, v + 3, v + 1});
  }
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) mesh.source.push_back(f);
  const ClSurface surface(mesh, Sides::kBoth, {ToolPiece{.flat = kFlatEnd, .outer = kFlatEnd}});
  const Deformation map({AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 1.0);
  const FlatIndex index(make_flat_hulls(surface, map, 0.1), map);
  const EnvelopeOptions limits{0.0005, 0.02};
  Envelope envelope(surface, map, index, limits);
  double most = 0.0;
  for (int i = 0; i < 40; ++i) {
    const LineEnvelope found = envelope.along({0.01 - kFlatEnd, 0.0, 1.0, 0.0, 0.2 + 0.0037 * i});
    ASSERT_EQ(found.passes.size(), 1U);
    const Pass& pass = found.passes[0];
    for (std::size_t k = 0; k + 1 < pass.size(); ++k)
      for (double share = 0.1; share < 1.0; share += 0.1) {
        const Point<Part> p = lerp(pass[k].centre, pass[k + 1].centre, share), rim{p.x + kFlatEnd, 0.0, p.z};
        double off = 1.0;
        for (const auto& [a, b] : profile) off = std::min(off, distance_to_segment(rim, a, b));
        most = std::max(most, off);
      }
  }
  EXPECT_LE(most, 1.1 * limits.tolerance);
}

/// Two level facets share an edge; beyond its end a notch opens, into which the ball sinks. Between points on
/// the two facets nothing but the way tells whether it passes over the edge or past its end.
// (envelope.h, property 2)
TEST(StraightMoves, ABallSinksPastTheEndOfACommonEdge) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {-30, 0, 0}, {10, -40, 0}, {10, 40, 0}};
  mesh.facets = {{0, 1, 2}, {1, 0, 3}};
  mesh.source = {0, 1};
  const ClSurface surface(mesh, Sides::kBoth, {ToolPiece{.corner = kBall, .outer = kBall}});
  const Deformation map({AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}, 1.0);
  const FlatIndex index(make_flat_hulls(surface, map, 0.1), map);
  const EnvelopeOptions limits{0.0025, 0.02};
  Envelope envelope(surface, map, index, limits);
  for (const double beyond : {-0.5, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.9}) {
    SCOPED_TRACE("row " + std::to_string(beyond) + " mm beyond the edge's end");
    const LineEnvelope found = envelope.along({beyond, -12.0, 0.0, 1.0, 24.0});
    ASSERT_EQ(found.passes.size(), 1U);
    const Pass& pass = found.passes[0];
    double highest = 0.0;
    for (std::size_t i = 0; i + 1 < pass.size(); ++i)
      for (double share = 0.0; share <= 1.0; share += 0.02) {
        const Point<Part> p = lerp(pass[i].centre, pass[i + 1].centre, share);
        const double outside = std::max(0.0, (4.0 * p.x - std::abs(p.y)) / std::sqrt(17.0));
        highest = std::max(highest, p.z - std::sqrt(kBall * kBall - outside * outside));
      }
    EXPECT_LE(highest, 1.1 * limits.tolerance);
    if (beyond < 0.0) {
      EXPECT_LE(pass.size(), 5U);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Ridges, StraightMovesTest,
                         testing::Values(Ridge{{7.0, -5.0, kTip}, {7.0, -5.0, kTip}},
                                         Ridge{{5.0, -9.0, kTip}, {8.0, -5.0, kTip}},
                                         Ridge{{6.0, -20.0, kTip}, {8.0, 12.0, kTip}}));

}  // namespace
}  // namespace tiltfeed
