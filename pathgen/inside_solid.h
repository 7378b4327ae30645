#pragma once
// Inside work from a point, line or circle that lies in the material: there the tool would come from inside
// the part, where no facet is in its way.

#include "kinematics/result.h"
#include "pathgen/mesh.h"
#include "pathgen/passes.h"
#include "pathgen/plan_report.h"

namespace tiltfeed {

/// Drops the passes that lie in the material, with a warning. Requires: no pass crosses the surface.
/// Errors: kUnreachable when none is left.
Result<void> leave_material(const Mesh& mesh, Passes& passes, PlanReport& report);

}  // namespace tiltfeed
