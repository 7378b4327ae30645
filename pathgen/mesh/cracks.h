#pragma once
// Cracks: facets that should be neighbours, but whose corners or edges lie a little apart.

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/mesh/weld.h"

namespace tiltfeed::pathgen {

/// Moves each corner on an open edge onto the lowest-numbered such corner within `distance`, if that one
/// stays where it is: no corner moves further than that, and no chain of moves arises. Facets that lose a
/// corner go, and so do those then on the corners of an earlier one. Returns the corners moved. Requires:
/// `fans` are those of `mesh`.
Found weld_corners(Mesh& mesh, const VertexFans& fans, double distance);

/// Cuts facets up where a corner of another open edge lies within `distance` of one of their open edges, so
/// that the corner becomes theirs: the edge moves by at most `distance`, no corner does. The pieces stand in
/// the place of the facet and keep its source. Returns the facets cut, each time they are.
Found split_at_corners(Mesh& mesh, double distance);

/// Removes facets that hang with one edge on one that already has two facets, where another of their edges
/// is open and their third corner is within `distance` of the edge they hang on.
Found drop_flaps(Mesh& mesh, double distance);

}  // namespace tiltfeed::pathgen
