// Of a drop at which only heights from some on are asked for: what is left out lies lower, what is found is
// the same, to the last bit.
#include "pathgen/tool/drop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tiltfeed {
using namespace pathgen;
namespace {

std::vector<ToolPiece> pieces() {
  const double taper = 0.2;
  return {{.corner = 2.0, .outer = 2.0},
          {.corner = 2.0, .outer = 2.0, .above_reference = 0.7},
          {.flat = 1.5, .corner = 0.5, .outer = 2.0},
          {.flat = 2.0, .outer = 2.0, .above_reference = 1.0},
          {.corner = 1.0, .taper_sin = std::sin(taper), .taper_cos = std::cos(taper), .outer = 3.0}};
}

struct Random {
  std::mt19937_64 engine{29};
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Point<Part> point(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  /// Any; now and then next to z, along which most lines run.
  Vec3 direction() {
    const Vec3 any = point(1.0) - Point<Part>{};
    return normalized(in(0, 1) < 0.3 ? Vec3{0, 0, 1} + any * std::pow(10.0, in(-7, 0)) : any);
  }
};

/// `drop(hit, least)` at heights beside the true one, from far off to rounding.
template <class Drop>
void expect_same(Random& random, const Drop& drop, std::size_t& left_out, std::size_t& found) {
  ClHit whole;
  const bool touches = drop(whole, kAnyHeight);
  for (const double off : {-3.0, -1e-3, -1e-7, -1e-12, 0.0, 1e-12, 1e-7, 1e-5, 1e-3, 3.0}) {
    const double least = (touches ? whole.z : random.in(-3, 3)) + off;
    ClHit hit;
    const bool seen = drop(hit, least);
    ASSERT_EQ(seen, touches && whole.z >= least) << "off " << off;
    if (!seen) {
      left_out += touches ? 1 : 0;
      continue;
    }
    ++found;
    EXPECT_EQ(hit.z, whole.z);
    EXPECT_EQ(hit.normal, whole.normal);
    EXPECT_EQ(hit.twist, whole.twist);
  }
}

TEST(DropFromSomeHeight, LeavesOutWhatIsLowerAndNothingElse) {
  Random random;
  for (const ToolPiece& piece : pieces()) {
    std::size_t left_out = 0, found = 0;
    for (int i = 0; i < 20000; ++i) {
      // Long edges and needles too, far from the line's base or near it, and steep.
      const double size = std::pow(10.0, random.in(-2, 2));
      const Point<Part> p = random.point(2.0), q = p + random.direction() * size,
                        r = p + random.direction() * size;
      const AxisLine line{random.point(2.0) + Vec3{0, 0, random.in(-300, 300)}, random.direction()};
      const Vec3 normal = cross(q - p, r - p);
      expect_same(
          random, [&](ClHit& hit, double least) { return drop_on_edge(piece, p, q, 1e-5, line, hit, least); },
          left_out, found);
      expect_same(
          random, [&](ClHit& hit, double least) { return drop_on_vertex(piece, p, line, hit, least); },
          left_out, found);
      if (!(length(normal) > 0.0)) continue;
      expect_same(
          random,
          [&](ClHit& hit, double least) {
            return drop_on_facet(piece, p, q, r, normalized(normal), 1e-5, line, hit, least);
          },
          left_out, found);
    }
    EXPECT_GT(left_out, 1000u);
    EXPECT_GT(found, 1000u);
  }
}

/// The tool let down on an edge stops at the highest of its points, each let down on by itself: there is a
/// drop where that is between the ends, and none where it is at one.
TEST(DropOnAnEdge, IsThatOfItsHighestPoint) {
  Random random;
  constexpr int kPlaces = 64;
  for (const ToolPiece& piece : pieces()) {
    std::size_t between = 0, at_end = 0;
    for (int i = 0; i < 4000; ++i) {
      const Point<Part> p = random.point(2.0), q = p + random.direction() * std::pow(10.0, random.in(-1, 1));
      const AxisLine line{random.point(1.0), random.direction()};
      const auto height = [&](double share) {
        ClHit hit;
        return drop_on_vertex(piece, lerp(p, q, share), line, hit) ? hit.z : kAnyHeight;
      };
      int best = 0;
      for (int k = 1; k <= kPlaces; ++k)
        if (height(1.0 * k / kPlaces) > height(1.0 * best / kPlaces)) best = k;
      if (height(1.0 * best / kPlaces) == kAnyHeight) continue;
      double low = std::max(best - 1, 0) / 64.0, high = std::min(best + 1, kPlaces) / 64.0;
      for (int k = 0; k < 60; ++k) {
        const double third = (high - low) / 3.0;
        (height(low + third) < height(high - third) ? low : high) =
            height(low + third) < height(high - third) ? low + third : high - third;
      }
      const double share = 0.5 * (low + high), top = height(share);
      // Where the wall or a flat bottom reaches the edge the highest point is no maximum of a smooth curve.
      const double off = 1e-3;
      const bool is_smooth = height(share - off) > kAnyHeight && height(share + off) > kAnyHeight;
      ClHit hit;
      const bool touches = drop_on_edge(piece, p, q, 1e-9, line, hit);
      if (share > 0.01 && share < 0.99 && is_smooth && top - height(share - off) > 1e-8 &&
          top - height(share + off) > 1e-8) {
        ++between;
        ASSERT_TRUE(touches) << "edge " << i;
        EXPECT_NEAR(hit.z, top, 1e-6) << "edge " << i;
      } else if (is_smooth && (share < 1e-6 || share > 1.0 - 1e-6) &&
                 top - height(share < 0.5 ? off : 1.0 - off) > 1e-6) {
        ++at_end;
        EXPECT_FALSE(touches) << "edge " << i;
      }
    }
    EXPECT_TRUE(between > 100u || piece.corner == 0.0) << between;
    EXPECT_GT(at_end, 100u);
  }
}

}  // namespace
}  // namespace tiltfeed
