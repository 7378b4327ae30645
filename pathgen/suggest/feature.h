#pragma once
// A point, line or circle that a part's surface is round about.

#include <algorithm>
#include <cstdint>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

/// A normal that passes a feature nearer than this share of the part's size meets it.
inline constexpr double kMeets = 0.004;

struct Feature {
  AxisMode mode = AxisMode::kLine;  ///< kPoint, kLine or kCircle
  Point<Part> centre;
  Vec3 axis{0, 0, 1};   ///< of a line or circle, unit
  double radius = 0.0;  ///< of a circle, mm
  double share = 0.0;   ///< of the surface whose normals meet it
  double rms = 0.0;     ///< of the distances of corners from the surfaces round it, mm
};

/// How far the normal of a flat facet, at a place of it, may pass what its surface is round about, mm: half
/// its height over its longest side, and rounding.
inline double facet_slack(const Mesh& mesh, std::uint32_t facet) {
  const auto& f = mesh.facets[facet];
  const Vec3 ab = mesh.vertices[f[1]] - mesh.vertices[f[0]], ac = mesh.vertices[f[2]] - mesh.vertices[f[0]];
  return 0.51 * length(cross(ab, ac)) / std::max({length(ab), length(ac), length(ac - ab)});
}

}  // namespace tiltfeed::pathgen
