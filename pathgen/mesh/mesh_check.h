#pragma once
// The check of a part: welded, oriented, repaired within a distance, its defects named.

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

/// The part of a job's tolerance that repair may take: as much as each approximation of the planner.
inline constexpr double kRepairShare = 0.25;

struct RepairOptions {
  /// How far repair may move the surface, mm; the default goes with a tolerance of 0.01 mm. 0: open edges and
  /// edges with more than two facets are only named. Holes: see pathgen/mesh/holes.h.
  double distance = 0.01 * kRepairShare;
};

/// Welds equal corners (exact equality of coordinates), drops degenerate and duplicate facets, orients,
/// repairs what is still not closed (pathgen/mesh/repair.h), and names every defect. Properties:
/// 1 Sides::kOutward if and only if each directed edge has exactly one opposite and the normals point out of
///   the material. Facets without area that join two neighbours (they seam a T-junction) count there. They
///   are dropped after that test: with them left out, their edges show one facet each.
/// 2 Where each directed edge had its opposite in the file, no corner moves. A repair moves none further than
///   distance / 2, and no facet further than distance; its fills are the only new surface. It closes all or
///   is not made: then no corner moves, and a warning says what stood against it.
/// 3 Facets keep the file's order; of duplicates the first stays.
/// 4 Nested shells: a void inside a shell keeps its normals into the void.
/// 5 The same for any number of threads.
/// Defects are counted in the file as read; what a repair did follows them under kinds of its own.
/// Errors: kMesh when nothing is left to plan, or coordinates are beyond kMaxCoordinate or not finite.
Result<CheckedMesh> check_mesh(const Stl& stl, const RepairOptions& options = {});
/// As check_mesh() without `report`. Errors: kCancelled, too.
Result<CheckedMesh> check_mesh(const Stl& stl, const RepairOptions& options, const ReportShare& report);

}  // namespace tiltfeed::pathgen
