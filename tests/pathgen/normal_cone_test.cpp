// Cones of contact normals against directions taken at random.

#include "pathgen/surface/normal_cone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "kinematics/basics/units.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kSlack = 2e-5;

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return normalized(Vec3{normal(random), normal(random), normal(random)});
}

/// Edges of a fan round the tip (0, 0, 0): tents, saddles and ridges, by how high each edge rises.
std::vector<Vec3> fan(std::mt19937& random, int count, double bend) {
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  std::vector<Vec3> spokes;
  for (int i = 0; i < count; ++i) {
    const double at = 2.0 * kPi * (i + 0.3 * share(random)) / count;
    const double far = 1.5 + share(random);  // drawn one after the other: every compiler makes the same fans
    spokes.push_back(Vec3{std::cos(at), std::sin(at), bend * share(random) - 0.3 * bend} * far);
  }
  return spokes;
}

std::vector<Vec3> facet_normals(const std::vector<Vec3>& spokes) {
  std::vector<Vec3> normals;
  for (std::size_t i = 0; i < spokes.size(); ++i)
    normals.push_back(normalized(cross(spokes[i], spokes[(i + 1) % spokes.size()])));
  return normals;
}

bool behind(const std::vector<Vec3>& spokes, Vec3 n) {
  return std::all_of(spokes.begin(), spokes.end(), [&](Vec3 e) { return dot(n, e) <= kSlack * length(e); });
}

/// Is n in the cone of a convex polygon's corners? Turning round them, it is on one side of every border.
bool in_cone(const std::vector<Vec3>& corners, Vec3 n, double spare) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 border = cross(corners[i], corners[(i + 1) % corners.size()]);
    const double side = dot(border, n);
    left += side < -spare * length(border) - 1e-12 ? 1 : 0;
    right += side > spare * length(border) + 1e-12 ? 1 : 0;
  }
  return left == 0 || right == 0;
}

TEST(NormalCone, HoldsEveryDirectionBehindAllSpokesAndLittleElse) {
  std::mt19937 random(5);
  int kept = 0, empty = 0, tested = 0, spare = 0;
  for (int k = 0; k < 4000; ++k) {
    const std::vector<Vec3> spokes = fan(random, 3 + k % 6, k % 2 == 0 ? 0.6 : 0.05);
    std::vector<Vec3> normals = facet_normals(spokes);
    const std::vector<Vec3> facets = normals;
    if (!cut_cone(normals, spokes, kSlack)) {
      ++empty;
      normals.clear();
    } else {
      if (normals == facets) continue;  // too wide: left alone
      ++kept;
    }
    for (int i = 0; i < 200; ++i) {
      // Mostly between the facets' normals, where there is something to find.
      Vec3 n{};
      for (Vec3 f : facets) n = n + f * std::exponential_distribution<double>(1.0)(random);
      n = i % 10 == 0 ? normalized(n + random_direction(random) * 0.3) : normalized(n);
      const bool accepted = behind(spokes, n);
      tested += accepted ? 1 : 0;
      if (accepted) {
        ASSERT_FALSE(normals.empty()) << "case " << k;
        ASSERT_TRUE(in_cone(normals, n, 1e-9)) << "case " << k;
      } else if (!normals.empty() && in_cone(normals, n, -1e-3)) {
        ++spare;  // inside the cone by 1e-3 and still in front of a spoke
      }
    }
  }
  EXPECT_GT(kept, 500);
  EXPECT_GT(empty, 500);
  EXPECT_GT(tested, 10000);
  EXPECT_EQ(spare, 0);
}

TEST(NormalCone, AStraightRidgeHasAnArcOnly) {
  std::vector<Vec3> spokes{{1, 0, 0}, {0, 1, -1}, {-1, 0, 0}, {0, -1, -1}};
  std::vector<Vec3> normals = facet_normals(spokes);
  ASSERT_TRUE(cut_cone(normals, spokes, kSlack));
  const NormalArc arc = widest_arc(normals);
  EXPECT_LT(arc.aside, 1e-4);
  EXPECT_NEAR(angle_between(arc.from, arc.to), kPi / 2.0, 1e-3);
  spokes[0].z = spokes[2].z = 0.01;  // sags: nothing can touch its lowest place
  normals = facet_normals(spokes);
  EXPECT_FALSE(cut_cone(normals, spokes, kSlack));
}

TEST(NormalCone, WideConesAreLeftAlone) {
  const std::vector<Vec3> spokes{{1, 0, -5}, {0, 1, -5}, {-1, 0, -5}, {0, -1, -5}};
  std::vector<Vec3> normals = facet_normals(spokes);
  const std::size_t before = normals.size();
  ASSERT_TRUE(cut_cone(normals, spokes, kSlack));
  EXPECT_EQ(normals.size(), before);
}

/// Distance of p from the triangle a, b, c, tried at many places of it.
double from_triangle(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
  double least = 1e9;
  constexpr int kSteps = 60;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j)
      least = std::min(least, length(a * (double(i) / kSteps) + b * (double(j) / kSteps) +
                                     c * (double(kSteps - i - j) / kSteps) - p));
  return least;
}

TEST(NormalCone, ArcAndApexHoldTheNormalsBetween) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int k = 0; k < 60; ++k) {
    const Vec3 a = random_direction(random), side = normalized(cross(a, random_direction(random)));
    const double turn = 0.05 + 1.9 * share(random);
    std::vector<Vec3> normals;
    for (double f : {0.0, 0.4, 1.0})
      for (double up : {-0.02, 0.02}) {
        const Vec3 on = a * std::cos(f * turn) + cross(side, a) * std::sin(f * turn);
        normals.push_back(normalized(on + side * (up * share(random))));
      }
    const NormalArc arc = widest_arc(normals);
    EXPECT_LT(arc.aside, 0.06);
    const Vec3 apex = arc_apex(arc);
    for (int i = 0; i < 40; ++i) {
      Vec3 n{};
      for (Vec3 corner : normals) n = n + corner * share(random);
      n = normalized(n);
      EXPECT_LE(from_triangle(n, arc.from, apex, arc.to), arc.aside + 0.02) << "case " << k;
    }
  }
}

}  // namespace
}  // namespace tiltfeed
