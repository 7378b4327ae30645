#pragma once
// What the passes leave between them where each place has its own tool axis: free or indexed. (U4) in
// pathgen/plan/README.md.

#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"
#include "pathgen/progress/watch.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

/// Of all cells of the surface the least distance to the tool on any cutting move of `path`. Where that is
/// more than the job lets its passes leave, the cell counts if the tool, in one of the unit `directions`,
/// would touch it clear of the part and within containment and tilt limit. Requires: a ball or taper-ball
/// cutter. The same for any number of threads. When the user stops it through `report`, what it returns is
/// worth nothing.
BetweenPasses find_rest_of_cells(const CheckedMesh& part, const PlanOptions& options, const SweptTool& tool,
                                 const std::vector<Vec3>& directions, const std::vector<Move>& path,
                                 const ReportShare& report = {});

}  // namespace tiltfeed::pathgen
