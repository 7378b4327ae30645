#pragma once
// Where a machinist would try first: the part's features, box and inertia. (Q3) in pathgen/suggest/README.md.

#include <span>
#include <string>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/reach/reach_scene.h"
#include "pathgen/suggest/feature.h"

namespace tiltfeed::pathgen {

struct Placement {
  AxisFrame axis;
  std::string source;
  double rms = 0.0;
};

/// Fixed axes, points, lines and circles in both senses; features first.
std::vector<Placement> first_placements(std::span<const Feature> features, const Box& bounds,
                                        std::span<const ReachPlace> places);

/// The frame with t and n turned so that the seam and the poles lie where least is cut. `cut`: places that
/// are.
AxisFrame well_turned(AxisFrame frame, std::span<const ReachPlace> cut);

/// Numbers as one would type them: within `length` (mm) and `angle` (rad) of the frame's own.
AxisFrame rounded(AxisFrame frame, double length, double angle);

/// A frame about this axis: t along it (line), or square to it (the others). `axis` unit.
AxisFrame frame_about(AxisMode mode, Sense sense, Point<Part> origin, Vec3 axis, double radius);
/// Its axis: t of a line, n of a fixed one, the normal of a circle.
Vec3 axis_of(const AxisFrame& frame);

}  // namespace tiltfeed::pathgen
