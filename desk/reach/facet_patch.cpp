#include "desk/reach/facet_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "kinematics/basics/units.h"

namespace tiltfeed::desk {
namespace {

using pathgen::FitKind;
using pathgen::Mesh;

/// Residuals that differ by less than this factor are the same; so are those below it, mm.
constexpr double kSameFit = 2.0, kExact = 1e-5, kMost = 1e300;

Vec3 normal_of(const Mesh& mesh, std::uint32_t facet) {
  const auto& f = mesh.facets[facet];
  const Point<Part> a = mesh.vertices[f[0]];
  return normalized(cross(mesh.vertices[f[1]] - a, mesh.vertices[f[2]] - a));
}

/// Facet and edge by the edge's corners: neighbours stand side by side.
struct Edge {
  std::uint32_t low, high, facet;
  bool operator<(const Edge& other) const {
    return std::array{low, high, facet} < std::array{other.low, other.high, other.facet};
  }
};

std::vector<Edge> edges_of(const Mesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.facets.size());
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({mesh.facets[i][k], mesh.facets[i][(k + 1) % 3]});
      edges.push_back({low, high, i});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

void spread(const Mesh& mesh, double cosine, std::vector<std::uint32_t>& todo, std::vector<bool>& taken) {
  const std::vector<Edge> edges = edges_of(mesh);
  while (!todo.empty()) {
    const std::uint32_t facet = todo.back();
    todo.pop_back();
    const Vec3 normal = normal_of(mesh, facet);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({mesh.facets[facet][k], mesh.facets[facet][(k + 1) % 3]});
      for (auto at = std::lower_bound(edges.begin(), edges.end(), Edge{low, high, 0});
           at != edges.end() && at->low == low && at->high == high; ++at) {
        if (taken[at->facet] || dot(normal, normal_of(mesh, at->facet)) < cosine) continue;
        taken[at->facet] = true;
        todo.push_back(at->facet);
      }
    }
  }
}

}  // namespace

FacetPatch smooth_patch(const Mesh& mesh, std::span<const std::uint32_t> sources, double spread_deg) {
  std::vector<bool> taken(mesh.facets.size(), false);
  std::vector<std::uint32_t> todo;
  for (const std::uint32_t source : sources)
    for (auto at = std::lower_bound(mesh.source.begin(), mesh.source.end(), source);
         at != mesh.source.end() && *at == source; ++at) {
      todo.push_back(static_cast<std::uint32_t>(at - mesh.source.begin()));
      taken[todo.back()] = true;
    }
  if (spread_deg > 0.0) spread(mesh, std::cos(Angle::from_degrees(spread_deg).radians()), todo, taken);
  FacetPatch patch;
  for (std::uint32_t i = 0; i < taken.size(); ++i) {
    if (!taken[i]) continue;
    patch.facets.push_back(i);
    if (patch.sources.empty() || patch.sources.back() != mesh.source[i])
      patch.sources.push_back(mesh.source[i]);
  }
  return patch;
}

std::vector<pathgen::Fit> fits_of(const Mesh& mesh, std::span<const std::uint32_t> facets) {
  const std::vector<pathgen::FitPoint> points = pathgen::corners_of(mesh, facets);
  std::vector<pathgen::Fit> found;
  // The simplest first: a plane is a cylinder of any radius, too.
  for (const FitKind kind :
       {FitKind::kPlane, FitKind::kSphere, FitKind::kCylinder, FitKind::kCircle, FitKind::kTorus})
    if (const Result<pathgen::Fit> fit = pathgen::fit(kind, points)) found.push_back(*fit);
  double best = kMost;
  for (const pathgen::Fit& fit : found) best = std::min(best, fit.rms);
  const auto rest = std::stable_partition(found.begin(), found.end(), [&](const pathgen::Fit& fit) {
    return fit.rms <= std::max(kSameFit * best, kExact);
  });
  std::stable_sort(rest, found.end(), [](const auto& a, const auto& b) { return a.rms < b.rms; });
  return found;
}

}  // namespace tiltfeed::desk
