#include "pathgen/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pathgen/topology.h"

namespace tiltfeed {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Circles wider than this many times what sticks out sideways are nearly straight beside it.
constexpr double kWideCircle = 4.0;

/// (S7) A contact `aside` of the axis line belongs to another place of the circle: its distance from that
/// place and its height on this line differ by a chord of up to twice `aside`, which sinks by chord^2 / (2
/// Ri).
double chord_sinks(const AxisFrame& frame, double aside) {
  if (frame.mode != AxisMode::kCircle) return 0.0;
  return frame.circle_radius < kWideCircle * aside ? kInfinity : 2.0 * aside * aside / frame.circle_radius;
}

}  // namespace

double highest_reference(const ClSurface& surface, const Deformation& map, PatchId patch) {
  const ToolPiece& piece = surface.piece(patch);
  const ClSurface::Core core = surface.core(patch);
  const double lift = piece.corner - piece.above_reference, aside = piece.outer;
  double top = -kInfinity, size = 0.0;
  for (Point<Part> p : core.points()) {
    top = std::max(top, map.flatten(p).z);
    size = std::max(size, distance(p, core.corner[0]));
  }
  if (map.frame().mode == AxisMode::kFixed) return top + lift;
  if (map.s() > 0.0) return top + lift + chord_sinks(map.frame(), aside);
  // Inside work: -z' is the distance from the feature, less along the axis line, and less between corners.
  const double near = std::max(0.0, -top - size);
  return lift - std::sqrt(std::max(0.0, near * near - aside * aside));
}

double lowest_reference(const ClSurface& surface, const Deformation& map) {
  const Mesh& mesh = surface.mesh();
  const ToolPiece& cutter = surface.pieces().front();
  const double aside = cutter.outer, sinks = chord_sinks(map.frame(), aside);
  const bool fixed = map.frame().mode == AxisMode::kFixed, outward = map.s() > 0.0;
  double lowest = kInfinity;
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
    const Facet& facet = mesh.facets[f];
    const Point<Part> a = mesh.vertices[facet[0]], b = mesh.vertices[facet[1]], c = mesh.vertices[facet[2]];
    const double size = std::max({distance(a, b), distance(b, c), distance(c, a)});
    double low = kInfinity, rho = kInfinity;
    for (Point<Part> p : {a, b, c}) {
      const double z = map.flatten(p).z;
      low = std::min(low, z), rho = std::min(rho, std::abs(z));
    }
    const double spread = fixed ? 0.0 : (size + aside) / std::max(rho - size - aside, 1e-9);
    if (surface.sides() == Sides::kOutward && surface.faces_away(f, 1, map.axis_at(a), spread)) continue;
    if (!fixed && outward) {  // nearer to the feature between corners, and seen from beside the axis line
      low = std::max(0.0, low - size);
      low = std::sqrt(std::max(0.0, low * low - aside * aside));
    }
    if (!fixed && !outward) low -= sinks;
    lowest = std::min(lowest, low);
  }
  return lowest - cutter.above_reference;
}

}  // namespace tiltfeed
