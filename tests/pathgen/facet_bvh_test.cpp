// The tree of facets against a look at all of them.

#include "pathgen/mesh/facet_bvh.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "pathgen/tool/swept_tool.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// A grid of bumps, its vertices shared, far from the origin.
Mesh bumps(int side) {
  Mesh mesh;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> high(0.0, 2.0);
  for (int i = 0; i <= side; ++i)
    for (int k = 0; k <= side; ++k) mesh.vertices.push_back(Point<Part>{500.0 + i, -300.0 + k, high(random)});
  const auto at = [&](int i, int k) { return static_cast<std::uint32_t>(i * (side + 1) + k); };
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      mesh.facets.push_back({at(i, k), at(i + 1, k), at(i, k + 1)});
      mesh.facets.push_back({at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  mesh.source.resize(mesh.facets.size());
  return mesh;
}

struct Found {
  double away = std::numeric_limits<double>::infinity();
  std::uint32_t facet = std::numeric_limits<std::uint32_t>::max();
  void take(double other, std::uint32_t f) {
    if (other < away || (other == away && f < facet)) away = other, facet = f;
  }
};

TEST(FacetBvh, TheNearestIsThatOfALookAtAllFacets) {
  for (const int side : {1, 2, 9, 40}) {
    const Mesh mesh = bumps(side);
    const FacetBvh tree(mesh);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> across(-5.0, side + 5.0), up(-6.0, 8.0), reaches(0.0, 6.0);
    std::uint64_t asked = 0;
    int none = 0;
    for (int k = 0; k < 400; ++k) {
      Point<Part> p{500.0 + across(random), -300.0 + across(random), up(random)};
      if (k % 5 == 0) p = mesh.vertices[static_cast<std::size_t>(k) % mesh.vertices.size()];  // ties
      const double reach = k % 3 == 0 ? std::numeric_limits<double>::infinity() : reaches(random);
      Found all, found;
      for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
        const double away = distance(p, nearest_point(p, tree.facet(f).corners));
        if (away < reach) all.take(away, f);
      }
      tree.nearest(p, reach, [&](std::uint32_t f, const PlacedFacet& placed) {
        ++asked;
        const double away = distance(p, nearest_point(p, placed.corners));
        if (away < reach) found.take(away, f);
        return away;
      });
      EXPECT_EQ(found.away, all.away) << side << " at " << k;
      EXPECT_EQ(found.facet, all.facet) << side << " at " << k;
      none += found.facet == std::numeric_limits<std::uint32_t>::max();
    }
    EXPECT_GT(none, 0);
    if (side == 40) {
      EXPECT_LT(asked, 400u * 3200u / 20u) << "not much is left out";
    }
  }
}

}  // namespace
}  // namespace tiltfeed
