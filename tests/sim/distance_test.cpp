// sim/distance and sim/triangle against closed forms, brute force over all facets with a point-triangle
// distance written differently, convex search along the segment, and sphere tracing.

#include "sim/solid/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "kinematics/basics/tool_path.h"
#include "tests/shapes/facet_soup.h"

namespace tiltfeed::sim {
using namespace pathgen;
namespace {

/// A bumpy closed surface round the origin: longitude-latitude grid with poles as fans.
std::vector<Corners> bumpy_ball(int rows, int columns) {
  const auto at = [&](int i, int j) -> Point<Part> {
    const double theta = kPi * i / rows, phi = 2.0 * kPi * (j % columns) / columns;
    if (i == 0) return {0, 0, 20};
    if (i == rows) return {0, 0, -20};
    const double r = 20.0 + 3.0 * std::sin(3.0 * phi) * std::sin(theta) * std::cos(5.0 * theta);
    return {r * std::sin(theta) * std::cos(phi), r * std::sin(theta) * std::sin(phi), r * std::cos(theta)};
  };
  std::vector<Corners> soup;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      if (i > 0) soup.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rows) soup.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return soup;
}

/// [Ericson 2005, section 5.1.5], by Voronoi regions: another way than the code under test takes.
double reference_distance(const Corners& t, Point<Part> p) {
  const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0], bp = p - t[1], cp = p - t[2];
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return length(ap);
  if (d3 >= 0 && d4 <= d3) return length(bp);
  if (d6 >= 0 && d5 <= d6) return length(cp);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return length(ap - ab * (d1 / (d1 - d3)));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return length(ap - ac * (d2 / (d2 - d6)));
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return length(bp - (t[2] - t[1]) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
  const double whole = va + vb + vc;
  return length(ap - ab * (vb / whole) - ac * (vc / whole));
}

double reference_distance(const std::vector<Corners>& soup, Point<Part> p) {
  double best = kInfinity;
  for (const Corners& t : soup) best = std::min(best, reference_distance(t, p));
  return best;
}

/// The distance to a triangle is convex along a segment: golden-section search finds its least value.
double reference_distance(const Corners& t, const Segment& s) {
  double low = 0.0, high = 1.0;
  constexpr double kGolden = 0.6180339887498949;
  for (int i = 0; i < 90; ++i) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    if (reference_distance(t, lerp(s.from, s.to, a)) <= reference_distance(t, lerp(s.from, s.to, b)))
      high = b;
    else
      low = a;
  }
  return reference_distance(t, lerp(s.from, s.to, 0.5 * (low + high)));
}

TEST(Distance, PointEqualsBruteForce) {
  std::mt19937_64 random(1);
  const auto soup = random_soup(random, 400, 10, 3);
  const PartDistance part(mesh_of(soup));
  std::uniform_real_distribution<double> place(-15, 15);
  for (int i = 0; i < 2000; ++i) {
    const Point<Part> p{place(random), place(random), place(random)};
    const Hit hit = part.nearest(p);
    ASSERT_NEAR(hit.value, reference_distance(soup, p), 1e-11) << p.x << ", " << p.y << ", " << p.z;
    ASSERT_NEAR(hit.value, reference_distance(soup[hit.facet], p), 1e-11);
  }
}

TEST(Distance, SegmentEqualsConvexSearch) {
  std::mt19937_64 random(2);
  const auto soup = random_soup(random, 60, 10, 3);
  const PartDistance part(mesh_of(soup));
  std::uniform_real_distribution<double> place(-12, 12), reach(-4, 4);
  int pierced = 0;
  for (int i = 0; i < 600; ++i) {
    const Point<Part> from{place(random), place(random), place(random)};
    const Segment s{from, from + Vec3{reach(random), reach(random), reach(random)}};
    double expected = kInfinity;
    for (const Corners& t : soup) expected = std::min(expected, reference_distance(t, s));
    const Hit hit = part.nearest(s);
    // Where the segment pierces, the search ends within its last interval of the zero.
    ASSERT_NEAR(hit.value, expected, 1e-7) << "segment " << i;
    if (hit.value == 0.0) ++pierced;
  }
  EXPECT_GT(pierced, 8);
}

TEST(Distance, SegmentsOfEveryPosition) {
  const Segment x{{0, 0, 0}, {10, 0, 0}};
  const struct {
    Segment other;
    double distance;
  } kCases[] = {
      {{{5, -1, 3}, {5, 1, 3}}, 3},     // crossing
      {{{12, 0, 0}, {20, 0, 0}}, 2},    // one line, apart
      {{{4, 0, 0}, {20, 0, 0}}, 0},     // one line, overlapping
      {{{-5, 2, 0}, {30, 2, 0}}, 2},    // parallel
      {{{13, 4, 0}, {13, 9, 0}}, 5},    // end to end
      {{{3, 4, 0}, {3, 4, 0}}, 4},      // a point
      {{{-3, -4, 0}, {-3, -4, 0}}, 5},  // a point past the end
  };
  for (const auto& c : kCases) {
    EXPECT_NEAR(std::sqrt(squared_distance(x, c.other)), c.distance, 1e-12);
    EXPECT_NEAR(std::sqrt(squared_distance(c.other, x)), c.distance, 1e-12);
  }
}

TEST(Distance, BoundAndHintOnlySaveTime) {
  std::mt19937_64 random(3);
  const auto soup = bumpy_ball(24, 40);
  const PartDistance part(mesh_of(soup));
  std::uniform_real_distribution<double> place(-30, 30);
  std::uniform_int_distribution<std::uint32_t> any(0, static_cast<std::uint32_t>(soup.size() - 1));
  for (int i = 0; i < 500; ++i) {
    const Point<Part> p{place(random), place(random), place(random)};
    const Segment s{p, p + normalized(from_origin(p)) * 15.0};
    const double whole = part.nearest(s).value;
    EXPECT_EQ(part.nearest(s, whole + 1e-9, any(random)).value, whole);
    EXPECT_EQ(part.nearest(s, whole * (1 - 1e-12)).facet, kNoFacet);
    EXPECT_EQ(part.nearest(s, whole * 0.5).value, whole * 0.5);
  }
}

TEST(Distance, BallFirstTouchesPlaneEdgeAndCorner) {
  // A square plate 20 x 20 at z = 0 made of two triangles; a ball of radius 2 comes down from z = 10.
  const Corners first{Point<Part>{0, 0, 0}, Point<Part>{20, 0, 0}, Point<Part>{20, 20, 0}};
  const Corners second{Point<Part>{0, 0, 0}, Point<Part>{20, 20, 0}, Point<Part>{0, 20, 0}};
  const PartDistance plate(mesh_of({first, second}));
  const Vec3 down{0, 0, -1};
  EXPECT_NEAR(plate.first_touch({7, 5, 10}, down, 2).value, 8.0, 1e-12);                    // face
  EXPECT_NEAR(plate.first_touch({9, 9, 10}, down, 2).value, 8.0, 1e-12);                    // the diagonal
  EXPECT_NEAR(plate.first_touch({10, -1.2, 10}, down, 2).value, 10 - 1.6, 1e-12);           // edge
  EXPECT_NEAR(plate.first_touch({-1, -1, 10}, down, 2).value, 10 - std::sqrt(2.0), 1e-12);  // corner
  EXPECT_EQ(plate.first_touch({-2.1, 5, 10}, down, 2).facet, kNoFacet);                     // passes by
  EXPECT_EQ(plate.first_touch({7, 5, 10}, {0, 0, 1}, 2).facet, kNoFacet);                   // goes away
  EXPECT_EQ(plate.first_touch({7, 5, 1.5}, down, 2).value, 0.0);                            // overlaps
  EXPECT_NEAR(plate.first_touch({-10, 5, 0}, {1, 0, 0}, 2).value, 8.0, 1e-12);              // edge on
  EXPECT_NEAR(plate.first_touch({-10, -10, 0}, normalized({1, 1, 0}), 2).value, std::sqrt(200.0) - 2, 1e-12);
  const Vec3 slanted = normalized({1, 0, -1});
  EXPECT_NEAR(plate.first_touch({0, 5, 10}, slanted, 2).value, 8.0 * std::sqrt(2.0), 1e-12);
  EXPECT_EQ(plate.first_touch({7, 5, 10}, down, 2, 7.9).facet, kNoFacet);  // beyond the bound
}

TEST(Distance, BallCastEqualsSphereTracing) {
  std::mt19937_64 random(4);
  const auto soup = random_soup(random, 120, 10, 3);
  const PartDistance part(mesh_of(soup));
  std::uniform_real_distribution<double> place(-14, 14), size(0.05, 2.0);
  int touched = 0;
  for (int i = 0; i < 300; ++i) {
    const Point<Part> from{place(random), place(random), 20};
    const Vec3 direction = normalized({place(random), place(random), -20});
    const double radius = size(random);
    const Hit hit = part.first_touch(from, direction, radius, 60.0);
    double s = 0.0;
    for (int step = 0; step < 3000 && s < 60.0; ++step) {
      const double gap = reference_distance(soup, from + direction * s) - radius;
      if (gap < 1e-10) break;
      s += gap;
    }
    // Sphere tracing never overshoots; it may stop short by 1e-10 / cos of a grazing touch.
    if (s < 60.0) {
      ++touched;
      ASSERT_NEAR(hit.value, s, 2e-5) << "cast " << i;
      ASSERT_NEAR(reference_distance(soup, from + direction * hit.value), radius, 1e-9) << "cast " << i;
    } else {
      ASSERT_EQ(hit.facet, kNoFacet) << "cast " << i;
    }
  }
  EXPECT_GT(touched, 100);
}

TEST(Distance, CastTouchesAtTheRadiusOnAClosedMesh) {
  std::mt19937_64 random(5);
  const auto soup = bumpy_ball(60, 90);
  const PartDistance part(mesh_of(soup));
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 axis = normalized({normal(random), normal(random), normal(random)});
    const Point<Part> start = Point<Part>{} + axis * 40.0;
    const Hit hit = part.first_touch(start, -axis, 2.0);
    ASSERT_NE(hit.facet, kNoFacet);
    const Point<Part> centre = start - axis * hit.value;
    EXPECT_NEAR(part.nearest(centre).value, 2.0, 1e-10);
    // The shank above the ball is clear: the capsule's clearance is the ball's.
    EXPECT_NEAR(part.nearest(tool_segment(centre - axis * 2.0, axis, 2.0, 40.0)).value, 2.0, 1e-10);
  }
}

TEST(Distance, WindingNumberTellsInsideFromOutside) {
  const PartDistance part(mesh_of(bumpy_ball(24, 40)));
  EXPECT_NEAR(part.winding_number({0, 0, 0}), 1.0, 1e-9);
  EXPECT_NEAR(part.winding_number({3, -4, 12}), 1.0, 1e-9);
  EXPECT_NEAR(part.winding_number({30, 2, 1}), 0.0, 1e-9);
}

TEST(Distance, NeedlesAndFacetsWithoutArea) {
  const Corners needle{Point<Part>{0, 0, 0}, Point<Part>{100, 0, 0}, Point<Part>{50, 1e-9, 0}};
  const Corners flat{Point<Part>{0, 0, 5}, Point<Part>{100, 0, 5}, Point<Part>{50, 0, 5}};
  const PartDistance part(mesh_of({needle, flat}));
  EXPECT_NEAR(part.nearest(Point<Part>{50, 0, 2}).value, 2.0, 1e-9);
  EXPECT_NEAR(part.nearest(Point<Part>{50, 4, 5}).value, 4.0, 1e-9);
  EXPECT_NEAR(part.first_touch({30, 0, 9}, {0, 0, -1}, 1.0).value, 3.0, 1e-9);
  EXPECT_NEAR(part.first_touch({30, 0, 4}, {0, 0, -1}, 0.5).value, 3.5, 1e-9);
  EXPECT_EQ(PartDistance(Mesh{}).nearest(Point<Part>{}).value, kInfinity);
}

}  // namespace
}  // namespace tiltfeed::sim
