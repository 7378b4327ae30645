#pragma once
// Indexed (3+2) machining: a few fixed tool directions that together reach the part, each for what it faces
// best, and the turns between them. (I1)..(I4) in pathgen/indexed/README.md.

#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"

namespace tiltfeed::pathgen {

/// As plan(), with AxisMode::kIndexed. Properties: every cutting move has one of at most
/// IndexedAxis::most_directions axes, and moves of one axis follow each other; between two axes the whole
/// tool stays beyond a sphere round the part, `links.clearance` wider than it, and never tilts further than
/// both. Errors: as plan(); kUnreachable when no direction reaches anything.
Result<Plan> plan_indexed(const CheckedMesh& part, const PlanOptions& options, const Progress& progress);

}  // namespace tiltfeed::pathgen
