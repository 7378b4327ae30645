#pragma once
// The mode free, stage by stage: slices of the CL surface, directions along them, links.

#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"

namespace tiltfeed::pathgen {

/// As plan(), with AxisMode::kFree; fills path.moves and the report. Properties: no gouge over the tolerance
/// by cutter, shank or holder on any move, contact within it on cutting moves; the tool can be drawn back
/// along its axis from every point; what has no admissible direction is left out and reported. Errors: as
/// plan().
Result<void> plan_free(const CheckedMesh& part, const PlanOptions& options, const Progress& progress,
                       Plan& plan);

}  // namespace tiltfeed::pathgen
