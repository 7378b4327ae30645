#include "pathgen/free_slices/patch_obstacles.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pathgen/free_slices/cl_chains.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

namespace {

/// A facet that stands out over the patch's planes by no more than this, mm, is behind them: a share of what
/// counts as inside.
constexpr double kBehind = 0.5 * kInside;
/// Patches that are looked at together.
constexpr std::size_t kTogether = 256;

bool touches(const PlacedFacet& facet, Point<Part> place) {
  return std::any_of(facet.corners.begin(), facet.corners.end(), [&](Point<Part> c) { return c == place; });
}

/// Are all centres of the patch on one side of the facet's plane, no nearer than the limit?
bool beyond_plane(const PatchHull& hull, const PlacedFacet& facet, double limit) {
  double low = 1e300, high = -1e300;
  for (int i = 0; i < hull.feet; ++i) {
    const double at = dot(facet.normal, from_origin(hull.foot[i])) - facet.offset;
    low = std::min(low, at), high = std::max(high, at);
  }
  const auto [from, to] = hull.normals.along(facet.normal);
  return low + std::min(from * hull.near, from * hull.far) >= limit ||
         high + std::max(to * hull.near, to * hull.far) <= -limit;
}

/// Is the facet behind each plane that touches the feature? Every centre is its radius away from one of them.
bool behind(const PatchHull& hull, const PlacedFacet& facet) {
  for (const Point<Part> corner : facet.corners) {
    const Vec3 from = corner - hull.foot[0];
    if (hull.supports > 0) {
      for (int i = 0; i < hull.supports; ++i)
        if (dot(from, hull.support[i]) > kBehind) return false;
    } else {
      const double away = length(from);
      if (away > 0.0 && hull.normals.along(from / away)[1] * away > kBehind) return false;
    }
  }
  return true;
}

}  // namespace

PatchObstacles::PatchObstacles(const ClSections& sections, const FacetBvh& tree,
                               const std::vector<std::uint8_t>& asked) {
  const std::size_t patches = sections.patches();
  std::vector<std::vector<std::uint32_t>> found((patches + kTogether - 1) / kTogether);
  first_.assign(patches + 1, 0);
  const double limit = sections.radius() - kInside;
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t block) {
    for (std::size_t p = block * kTogether; p < std::min(patches, (block + 1) * kTogether); ++p) {
      if (asked[p] == 0) continue;
      const PatchHull hull = sections.hull(static_cast<std::uint32_t>(p));
      const std::size_t before = found[block].size();
      tree.any_along(
          hull.middle, {0, 0, 1}, 0.0, 0.0, limit + hull.reach,
          [&](std::uint32_t f, const PlacedFacet& facet) {
            if (behind(hull, facet) || beyond_plane(hull, facet, limit)) return false;
            if (hull.is_vertex && touches(facet, hull.foot[0])) return false;
            if (distance(hull.middle, nearest_point(hull.middle, facet.corners)) >= limit + hull.reach)
              return false;
            found[block].push_back(f);
            return false;
          });
      std::sort(found[block].begin() + static_cast<std::ptrdiff_t>(before), found[block].end());
      first_[p + 1] = found[block].size() - before;
    }
  });
  for (std::size_t p = 0; p < patches; ++p) first_[p + 1] += first_[p];
  facets_.reserve(first_.back());
  for (const auto& some : found) facets_.insert(facets_.end(), some.begin(), some.end());
}

}  // namespace tiltfeed::pathgen
