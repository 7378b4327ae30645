// Slices of the whole CL surface against closed forms and against the judge's own distances.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "pathgen/free_slices/cl_chains.h"
#include "pathgen/free_slices/cl_slices.h"
#include "pathgen/free_slices/patch_obstacles.h"
#include "pathgen/free_slices/stack_share.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/parts/parts.h"
#include "sim/solid/distance.h"
#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using soup::operator+;

constexpr double kTolerance = 0.004;

PlanOptions options(double diameter, std::vector<Vec3> normals, double step) {
  PlanOptions o;
  o.cutter.diameter = diameter, o.cutter.shank_length = 50, o.cutter.length = 80;
  o.free.plane_normals = std::move(normals);
  o.pattern.side_step = step;
  return o;
}

std::vector<ClSlice> slices(const CheckedMesh& part, const PlanOptions& o) {
  const FacetBvh tree(part.mesh);
  return slice_cl_surface(part, tree, o, ToleranceBudget(kTolerance / 0.4), [](double) { return true; });
}

/// Every point and every middle of a move is in contact with the part, and on its plane.
void expect_contact(const CheckedMesh& part, const PlanOptions& o, const std::vector<ClSlice>& found) {
  const sim::PartDistance distance_to(part.mesh);
  const double r = o.cutter.radius();
  for (const ClSlice& s : found) {
    const ClStrand& p = s.chain.points;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double d = distance_to.nearest(p[i].centre).value;
      ASSERT_GE(d, r - kTolerance);
      ASSERT_LE(d, r + kTolerance);
      ASSERT_NEAR(dot(from_origin(p[i].centre), o.free.plane_normals[s.stack]), s.height, kTolerance);
      ASSERT_NEAR(length(p[i].normal), 1.0, 1e-9);
      if (i == 0) continue;
      const double middle = distance_to.nearest(lerp(p[i - 1].centre, p[i].centre, 0.5)).value;
      ASSERT_GE(middle, r - kTolerance) << "move " << i << " of the slice at " << s.height;
      ASSERT_LE(middle, r + kTolerance) << "move " << i << " of the slice at " << s.height;
    }
  }
}

TEST(FreeSlices, ACubeIsGoneRoundAlongItsSidesAndQuarterCircles) {
  const CheckedMesh part = soup::check(soup::cube(0, 20));
  const auto found = slices(part, options(6, {{0, 0, 1}}, 4));
  // From -3 to 23: seven planes, two of them above and below the cube where the ball rolls over its rims.
  double levels = 0;
  for (const ClSlice& s : found) {
    EXPECT_TRUE(s.chain.closed);
    if (s.height <= 0.0 || s.height >= 20.0) continue;
    ++levels;
    EXPECT_NEAR(length_of(s.chain.points), 80 + 6 * kPi, 0.02) << s.height;
  }
  EXPECT_EQ(levels, 5);
  expect_contact(part, options(6, {{0, 0, 1}}, 4), found);
}

TEST(FreeSlices, AHollowCornerIsCutShort) {
  const CheckedMesh part = soup::check(soup::ell());
  const auto found = slices(part, options(1, {{0, 0, 1}}, 1));
  int levels = 0;
  for (const ClSlice& s : found) {
    if (s.height <= 0.0 || s.height >= 6.0) continue;
    ++levels;
    EXPECT_TRUE(s.chain.closed);
    EXPECT_NEAR(length_of(s.chain.points), 24 - 2 * 0.5 + 5 * kPi / 2 * 0.5, 0.02);
  }
  EXPECT_GE(levels, 5);
  expect_contact(part, options(1, {{0, 0, 1}}, 1), found);
}

/// Round each rim the normals make half a turn, and the sheet goes on in the plane of both their ends.
TEST(FreeSlices, ANotchInALevelSheetIsCutShort) {
  soup::Soup sheet;
  const auto tile = [&](double x, double y) {
    soup::add_quad(sheet, {x, y, 0}, {x + 5, y, 0}, {x + 5, y + 5, 0}, {x, y + 5, 0});
  };
  tile(0, 0), tile(5, 0), tile(0, 5);
  const CheckedMesh part = soup::check(sheet);
  ASSERT_EQ(part.sides, Sides::kBoth);
  for (const Vec3 n : {Vec3{0, 0, 1}, normalized(Vec3{1, 0.2, 0.1}), normalized(Vec3{-0.4, -0.3, 0.8})}) {
    const PlanOptions o = options(2.4, {n}, 0.7);
    expect_contact(part, o, slices(part, o));
  }
}

TEST(FreeSlices, AHollowUnderAnOverhangIsFollowedToItsCorner) {
  // A floor, and a wall that leans over it by 20 degrees.
  const double lean = 20.0 * kPi / 180.0, r = 1.0, missing = 0.5;
  const Vec3 up{0, -std::sin(lean), std::cos(lean)}, off{0, -std::cos(lean), -std::sin(lean)};
  const auto wall = [&](double x, double along) { return Point<Part>{x, 0, 0} + up * along; };
  Mesh mesh;
  mesh.vertices = {{-9, -9, 0}, {9, -9, 0}, {9, 0, 0}, {-9, 0, 0}, wall(9, 9), wall(-9, 9)};
  mesh.facets = {{0, 1, 2}, {0, 2, 3}, {3, 2, 4}, {3, 4, 5}};
  mesh.source = {0, 1, 2, 3};
  const Point<Part> corner{0, -(r + std::sin(lean) * r) / std::cos(lean), r};
  ClStrand floor, over;
  for (int i = 0; i <= 40; ++i) floor.push_back({corner - Vec3{0, 0.05 * (40 - i), 0}, {0, 0, 1}, 0});
  for (int i = 0; i <= 40; ++i) over.push_back({corner + up * (missing + 0.05 * i), off, 2});
  const auto chains = join_strands({floor, over}, FacetBvh(mesh), r, {kTolerance, 1.0, kTolerance, 0.0});
  ASSERT_EQ(chains.size(), 1u);
  const sim::PartDistance distance_to(mesh);
  const ClStrand& p = chains[0].points;
  EXPECT_NEAR(length_of(p), 2.0 + missing + 2.0, kTolerance);
  for (std::size_t i = 1; i < p.size(); ++i)
    EXPECT_NEAR(distance_to.nearest(lerp(p[i - 1].centre, p[i].centre, 0.5)).value, r, kTolerance);
}

TEST(FreeSlices, ACavityIsSlicedToo) {
  const CheckedMesh part = soup::check(soup::cube(0, 40) + soup::reversed(soup::cube(10, 30)));
  const auto found = slices(part, options(6, {{0, 0, 1}}, 5));
  double inside = 0.0, outside = 0.0;
  for (const ClSlice& s : found) {
    const Point<Part> p = s.chain.points.front().centre;
    const bool in = p.x > 5 && p.x < 35 && p.y > 5 && p.y < 35 && p.z > 5 && p.z < 35;
    (in ? inside : outside) += length_of(s.chain.points);
    if (in) {
      EXPECT_NEAR(length_of(s.chain.points), 4 * (20 - 6), 0.02);
    }
  }
  EXPECT_GT(inside, 100.0);
  EXPECT_GT(outside, 500.0);
  expect_contact(part, options(6, {{0, 0, 1}}, 5), found);
}

TEST(FreeSlices, AnyNormalCutsInContact) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const CheckedMesh torus = soup::check(soup::torus()), ell = soup::check(soup::ell());
  for (int i = 0; i < 12; ++i) {
    const Vec3 n = normalized({normal(random), normal(random), normal(random)});
    SCOPED_TRACE(testing::Message() << "normal " << n.x << ", " << n.y << ", " << n.z);
    const PlanOptions o = options(i % 2 ? 1.5 : 0.6, {n}, 0.7);
    const CheckedMesh& part = i % 3 == 0 ? torus : ell;
    const auto found = slices(part, o);
    EXPECT_GT(found.size(), 4u);
    expect_contact(part, o, found);
  }
}

TEST(FreeSlices, TheHollowSphereIsCutInsideAndOutInUnbrokenPasses) {
  Stl stl;
  stl.facets = sim::hollow_sphere();
  const Result<CheckedMesh> part = check_mesh(stl);
  ASSERT_TRUE(part.has_value());
  const PlanOptions o = options(10, {{1, 0, 0}}, 10);
  const auto found = slices(*part, o);
  expect_contact(*part, o, found);
  std::size_t closed = 0;
  double inside = 0.0;
  for (const ClSlice& s : found) {
    closed += s.chain.closed ? 1 : 0;
    if (length(from_origin(s.chain.points.front().centre)) < 36.0) inside += length_of(s.chain.points);
  }
  EXPECT_GT(inside, 500.0);
  EXPECT_GE(closed * 10, found.size() * 8);
}

/// Calls visit(patch, strand, normal of the plane) for the strands of a few planes.
template <class Visit>
void each_strand(const ClSections& sections, const Visit& visit) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 8; ++i) {
    const Vec3 n = normalized({normal(random), normal(random), normal(random)});
    for (std::uint32_t patch = 0; patch < sections.patches(); ++patch) {
      const auto [low, high] = sections.extent(patch, n);
      std::vector<ClStrand> strands;
      for (const double share : {0.01, 0.3, 0.6, 0.99})
        sections.cut(patch, n, low + share * (high - low), strands);
      for (const ClStrand& strand : strands) visit(patch, strand, n);
      strands.clear();
      sections.cut(patch, n, low - 1e-6, strands), sections.cut(patch, n, high + 1e-6, strands);
      EXPECT_TRUE(strands.empty()) << "patch " << patch << " beyond its extent";
    }
  }
}

TEST(FreeSlices, OnlyObstaclesCutIntoAPatch) {
  for (const CheckedMesh& part : {soup::check(soup::torus()), soup::check(soup::ell())}) {
    const FacetBvh tree(part.mesh);
    const ClSections sections(part, 0.8, 0.001);
    const PatchObstacles obstacles(sections, tree, std::vector<std::uint8_t>(sections.patches(), 1));
    std::vector<std::uint32_t> all(part.mesh.facets.size());
    std::iota(all.begin(), all.end(), 0u);
    std::size_t listed = 0, cut_short = 0;
    for (std::uint32_t p = 0; p < sections.patches(); ++p) listed += obstacles.of(p).size();
    EXPECT_LT(listed, sections.patches() * all.size() / 4);
    each_strand(sections, [&](std::uint32_t patch, const ClStrand& strand, Vec3) {
      std::vector<ClStrand> kept, expected;
      trim_strand(strand, tree, obstacles.of(patch), sections.radius(), kept);
      trim_strand(strand, tree, all, sections.radius(), expected);
      double length = 0.0, wanted = 0.0;
      for (const ClStrand& s : kept) length += length_of(s);
      for (const ClStrand& s : expected) wanted += length_of(s);
      ASSERT_NEAR(length, wanted, 1e-6) << "patch " << patch;
      cut_short += wanted < length_of(strand) - 1e-6 ? 1 : 0;
    });
    EXPECT_GT(cut_short, 0u);
  }
}

TEST(FreeSlices, AStackCutsAllPatchesThatHavePlacesOfIt) {
  const CheckedMesh part = soup::check(soup::torus());
  PlanOptions o = options(1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0.05);
  o.containment.height = {0.0, 0.3};
  const ClSections sections(part, 0.5, 0.001);
  for (std::uint32_t stack = 0; stack < 3; ++stack) {
    const auto needed = stack_share(sections, stack, o, 0.1);
    EXPECT_LT(std::count(needed.begin(), needed.end(), 1), std::ssize(needed) * 3 / 4);
    each_strand(sections, [&](std::uint32_t patch, const ClStrand& strand, Vec3) {
      for (const ClPoint& p : strand)
        if (owned_by(stack, p.normal, o) && o.containment.height.contains(p.centre.z)) {
          ASSERT_EQ(needed[patch], 1) << "patch " << patch << " of stack " << stack;
        }
    });
  }
}

/// A move over a hollow of two planes, deepest at a share of the way: its middle tells only what it is there.
TEST(FreeSlices, AMoveIsInContactAllAlongOrNot) {
  constexpr double kRadius = 2.0, kDepth = 0.01;
  for (const double deepest : {0.1, 0.2, 0.5, 0.8, 0.97}) {
    Mesh mesh;
    // Off a plane by the radius at `at`, and by the depth more at the deepest place.
    const auto add = [&](double at) {
      const double lean = kDepth / (deepest - at), up = std::sqrt(1.0 - lean * lean);
      const Vec3 n{lean, 0.0, up}, along{up, 0.0, -lean}, aside{0.0, 1.0, 0.0};
      const Point<Part> foot = Point<Part>{at, 0.0, 0.0} - n * kRadius;
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const auto& [u, v] : {std::pair{-20.0, -20.0}, std::pair{20.0, -20.0}, std::pair{0.0, 30.0}})
        mesh.vertices.push_back(foot + along * u + aside * v);
      mesh.facets.push_back({first, first + 1, first + 2}), mesh.source.push_back(first / 3);
    };
    add(0.0), add(1.0);
    const FacetBvh tree(mesh);
    const auto in = [&](double tolerance) {
      return in_contact({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, tree, kRadius, tolerance);
    };
    EXPECT_TRUE(in(1.001 * kDepth)) << deepest;
    EXPECT_FALSE(in(0.999 * kDepth)) << deepest;
    EXPECT_FALSE(in(0.5 * kDepth)) << deepest;
  }
}

TEST(FreeSlices, EveryPlaceBelongsToTheStackThatCutsItMostSquarely) {
  const CheckedMesh part = soup::check(soup::cube(0, 20));
  const PlanOptions o = options(4, {{1, 0, 0}, {0, 0, 1}}, 2);
  for (const ClSlice& s : slices(part, o))
    for (std::size_t i = 1; i < s.chain.points.size(); ++i) {
      const ClPoint& p = s.chain.points[i];
      EXPECT_FALSE(std::abs(p.normal.x) > 0.99 && s.stack != 1u);
      EXPECT_FALSE(std::abs(p.normal.z) > 0.99 && s.stack != 0u);
    }
}

TEST(FreeSlices, TheContainmentIsABoxOfCentres) {
  const CheckedMesh part = soup::check(soup::cube(0, 20));
  PlanOptions o = options(4, {{1, 0, 0}}, 2);
  o.containment.height = {5.0, 15.0};
  const auto found = slices(part, o);
  double low = 1e9, high = -1e9;
  for (const ClSlice& s : found)
    for (const ClPoint& p : s.chain.points)
      low = std::min(low, p.centre.z), high = std::max(high, p.centre.z);
  EXPECT_NEAR(low, 5.0, 1e-9);
  EXPECT_NEAR(high, 15.0, 1e-9);
}

}  // namespace
}  // namespace tiltfeed
