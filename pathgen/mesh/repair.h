#pragma once
// Repair of a mesh that is not closed, or touches itself: within a stated distance, or not at all (CGAL).

#include <optional>
#include <string>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/mesh/weld.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

struct Repair {
  /// Every directed edge has its opposite and normals point out of the material; facets are in the file's
  /// order. A piece of a facet keeps its source; a fill has that of a facet beside the hole. Facets without
  /// area may seam, as in Welded. Nothing where `obstacle` says why.
  std::optional<Mesh> mesh;
  std::string obstacle;
  Found welded;              ///< corners moved onto another
  Found split;               ///< facets cut up at a neighbour's corner
  Found flaps;               ///< facets removed that hang on an edge of others
  Found separated;           ///< edges along which solids touch, whose corners were doubled
  Found filled;              ///< holes; `first` is a facet beside one
  Found flipped;             ///< facets turned over to agree with their neighbours
  Found inside_out;          ///< shells turned over
  double widest_hole = 0.0;  ///< of those filled, mm
};

/// Closes `mesh`, or says why it cannot be. In this order: corners of open edges are welded, facets cut up at
/// corners that lie on their edges, flaps dropped (cracks.h), neighbours made to agree (facet_winding.h),
/// touching solids given corners of their own (pinches.h), holes filled (holes.h), shells turned outward.
/// Properties: 1 No corner moves by more than distance / 2, and no facet but a fill is further than
/// `distance` from the
///   one it comes from.
/// 2 Welds and cuts reach no further than needed: of distance / 32, / 8 and / 2 the least that leaves the
///   fewest edges open is tried first, then those above it.
/// 3 No two facets cross that did not before: where a repair would make some, there is none.
/// 4 All or nothing: what keeps one hole keeps all.
/// `report`: is told how far it is; its answer is not heeded.
/// Requires: `fans` are those of `mesh`; sources ascend; distance > 0.
Repair repair(const Mesh& mesh, const VertexFans& fans, double distance, const ReportShare& report = {});

}  // namespace tiltfeed::pathgen
