// How high a piece of the tool can be held up by a feature of the part. (G2) in pathgen/pattern/README.md.

#include <algorithm>
#include <cmath>
#include <limits>

#include "pathgen/surface/flat_hulls.h"

namespace tiltfeed::pathgen {

/// The contact is on the feature, at most `outer` beside the axis line.
double highest_reference(const ClSurface& surface, const Deformation& map, PatchId patch) {
  const ToolPiece& piece = surface.piece(patch);
  const ClSurface::Core core = surface.core(patch);
  const AxisFrame& frame = map.frame();
  const double lift = piece.corner - piece.above_reference, aside = piece.outer;
  double top = -std::numeric_limits<double>::infinity(), size = 0.0;
  for (Point<Part> p : core.points()) {
    top = std::max(top, map.height(p));
    size = std::max(size, distance(p, core.corner[0]));
  }
  if (frame.mode == AxisMode::kFixed) return top + lift;
  if (map.s() > 0.0) {
    if (frame.mode != AxisMode::kCircle) return top + lift;
    // The contact may be nearest to a place of the circle further round, by an angle whose sine is at most
    // aside / r: from there its distance is the lesser by what the circle bends.
    double r = std::numeric_limits<double>::infinity();
    for (Point<Part> p : core.points()) {
      const Vec3 d = p - frame.origin;
      r = std::min(r, std::hypot(dot(d, frame.t), dot(d, frame.n)));
    }
    // Nor is it a corner: along a chord of length l nearer to the axis of Theta than the circle is, r bows in
    // by l^2 / (8 r) and the distance from the circle grows by as much; in a facet twice.
    const double nearest = std::sqrt(std::max(0.0, r * r - 0.5 * size * size));
    const double bow = std::min(size, size * size / (4.0 * std::max(nearest, 1e-9)));
    const double sine = aside / std::max(r - size, 1e-9);
    return top + bow + lift + frame.circle_radius * (sine < 1.0 ? 1.0 - std::sqrt(1.0 - sine * sine) : 2.0);
  }
  // Inside work: -z' is the distance from the feature, less along the axis line, and less between corners.
  const double near = std::max(0.0, -top - size);
  return lift - std::sqrt(std::max(0.0, near * near - aside * aside));
}

}  // namespace tiltfeed::pathgen
