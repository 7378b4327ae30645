#pragma once
// Inside work from a point, line or circle that lies in the material: there the tool would come from inside
// the part, where no facet is in its way.

#include "kinematics/result.h"
#include "pathgen/mesh.h"
#include "pathgen/passes.h"
#include "pathgen/plan.h"

namespace tiltfeed {

/// How often the surface winds round p: 1 inside, 0 outside a closed mesh [Van Oosterom, Strackee 1983].
/// Looks at every facet.
double winding_number(const Mesh& mesh, Point<Part> p);

/// Drops the passes that lie in the material, with a warning. Requires: no pass crosses the surface.
/// Errors: kUnreachable when none is left.
Result<void> leave_material(const Mesh& mesh, Passes& passes, PlanReport& report);

}  // namespace tiltfeed
