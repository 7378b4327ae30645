#pragma once
// Where the tool stands when it touches a place of the part, and its axis there.

#include "pathgen/axis/deformation.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

/// (C1) The place of the CL reference, and the axis, with `piece` of the tool in contact with `place`, whose
/// normal is n.
AxisLine contact_line(const ToolPiece& piece, const Deformation& deformation, Point<Part> place, Vec3 n);

/// The same for one axis everywhere.
Point<Part> contact_reference(const ToolPiece& piece, Vec3 axis, Point<Part> place, Vec3 n);

/// A facet that leans over by less (sine) counts as a wall: rounding of STL corners.
inline constexpr double kWallLean = 1e-4;

}  // namespace tiltfeed::pathgen
