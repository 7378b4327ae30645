#include "pathgen/mesh/folds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/winding_number.h"

namespace tiltfeed::pathgen {

namespace {

constexpr std::size_t kLeastAsked = 16;
/// How far behind an edge is asked, as a share of its length, and at most, mm.
constexpr double kBehind = 1e-3, kFurthest = 1e-3;
/// Normals that point against each other more closely than this leave no direction between them.
constexpr double kOpposite = 1e-6;
/// Above this the surface winds round the place: material.
constexpr double kInside = 0.5;

Vec3 normal_of(const Mesh& mesh, std::uint32_t facet) {
  const auto& [a, b, c] = mesh.facets[facet];
  return normalized(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
}

/// Just behind the middle of the edge; nothing where there is no telling what is behind.
std::optional<Point<Part>> behind(const Mesh& mesh, const NarrowNotch& notch) {
  const Point<Part> low = mesh.vertices[notch.low], high = mesh.vertices[notch.high];
  const Vec3 open = normal_of(mesh, notch.facets[0]) + normal_of(mesh, notch.facets[1]);
  const double width = length(open);
  if (width < kOpposite) return std::nullopt;
  return lerp(low, high, 0.5) - open * (std::min(kBehind * distance(low, high), kFurthest) / width);
}

}  // namespace

std::vector<std::uint32_t> folded_facets(const Mesh& mesh, std::span<const NarrowNotch> notches) {
  const std::size_t most =
      std::max(kLeastAsked, kMostFoldLooks / std::max<std::size_t>(1, mesh.facets.size()));
  const std::size_t stride = 1 + notches.size() / (most + 1);
  std::vector<std::uint32_t> folded((notches.size() + stride - 1) / stride, kNoFacet);
  tbb::parallel_for(std::size_t{0}, folded.size(), [&](std::size_t i) {
    const NarrowNotch& notch = notches[i * stride];
    const std::optional<Point<Part>> place = behind(mesh, notch);
    if (place && winding_number(mesh, *place) < kInside) folded[i] = notch.facets[0];
  });
  std::erase(folded, kNoFacet);
  std::sort(folded.begin(), folded.end());
  folded.erase(std::unique(folded.begin(), folded.end()), folded.end());
  return folded;
}

}  // namespace tiltfeed::pathgen
