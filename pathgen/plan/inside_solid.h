#pragma once
// Work from a point, line or circle that lies in the material, or from the axis of Theta (inner half of a
// circle, outside work): there the tool would come from inside the part, where no facet is in its way.

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_report.h"
#include "pathgen/pattern/passes.h"

namespace tiltfeed::pathgen {

/// Drops the passes that lie in the material, with a warning. Requires: no pass crosses the surface.
/// Errors: kUnreachable when none is left.
Result<void> leave_material(const Mesh& mesh, Sense sense, Passes& passes, PlanReport& report);

}  // namespace tiltfeed::pathgen
