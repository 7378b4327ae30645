#pragma once
// On which side of a closed surface a point lies.

#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

/// How often the surface winds round p: 1 inside, 0 outside a closed mesh [Van Oosterom, Strackee 1983].
/// Looks at every facet.
double winding_number(const Mesh& mesh, Point<Part> p);

}  // namespace tiltfeed::pathgen
