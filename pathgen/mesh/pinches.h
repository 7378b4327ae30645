#pragma once
// Pinches: edges along which two solids, or two places of one, touch.

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/mesh/weld.h"

namespace tiltfeed::pathgen {

/// Gives each solid that touches another along an edge (four facets, or six ...) corners of its own there, at
/// the same place: every edge then has the two facets that enclose material. Facets are paired by their angle
/// round the edge; where they do not alternate between entering and leaving material, or lie on each other,
/// the edge stays. A mesh of negative volume counts as inside out as a whole. Returns the edges separated; no
/// corner moves. Requires: neighbours agree.
Found separate_pinches(Mesh& mesh);

}  // namespace tiltfeed::pathgen
