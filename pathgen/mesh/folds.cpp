#include "pathgen/mesh/folds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <span>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/winding_number.h"

namespace tiltfeed {

namespace {

constexpr std::size_t kLeastAsked = 16;
/// How far behind an edge is asked, as a share of its length, and at most, mm.
constexpr double kBehind = 1e-3, kFurthest = 1e-3;
/// Normals that point against each other more closely than this leave no direction between them.
constexpr double kOpposite = 1e-6;
/// Above this the surface winds round the place: material.
constexpr double kInside = 0.5;

struct Notch {
  Point<Part> behind;
  std::uint32_t facet = 0;
};

Vec3 normal_of(const Mesh& mesh, std::uint32_t facet) {
  const auto& [a, b, c] = mesh.facets[facet];
  return normalized(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
}

std::vector<Notch> narrow_notches(const Mesh& mesh) {
  std::vector<Notch> found;
  const VertexFans fans(mesh.facets, mesh.vertices.size());
  fans.each_edge([&](std::span<const HalfEdge> halves) {
    if (halves.size() != 2) return;
    const Point<Part> low = mesh.vertices[halves[0].low], high = mesh.vertices[halves[0].high];
    const Vec3 n = normal_of(mesh, halves[0].facet), m = normal_of(mesh, halves[1].facet);
    if (dot(n, m) >= 0.0) return;
    double rise = 0.0;
    for (const std::uint32_t v : mesh.facets[halves[1].facet])
      if (v != halves[0].low && v != halves[0].high) rise = dot(n, mesh.vertices[v] - low);
    const Vec3 open = n + m;
    const double width = length(open);
    if (rise <= 0.0 || width < kOpposite) return;
    const double by = std::min(kBehind * distance(low, high), kFurthest);
    found.push_back({lerp(low, high, 0.5) - open * (by / width), halves[0].facet});
  });
  return found;
}

}  // namespace

std::vector<std::uint32_t> folded_facets(const Mesh& mesh) {
  const std::vector<Notch> notches = narrow_notches(mesh);
  const std::size_t most =
      std::max(kLeastAsked, kMostFoldLooks / std::max<std::size_t>(1, mesh.facets.size()));
  const std::size_t stride = 1 + notches.size() / (most + 1);
  std::vector<std::uint32_t> folded((notches.size() + stride - 1) / stride, kNoFacet);
  tbb::parallel_for(std::size_t{0}, folded.size(), [&](std::size_t i) {
    const Notch& notch = notches[i * stride];
    if (winding_number(mesh, notch.behind) < kInside) folded[i] = notch.facet;
  });
  std::erase(folded, kNoFacet);
  std::sort(folded.begin(), folded.end());
  folded.erase(std::unique(folded.begin(), folded.end()), folded.end());
  return folded;
}

}  // namespace tiltfeed
