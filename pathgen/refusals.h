#pragma once
// What a pass leaves out, and why, told to the user.

#include "kinematics/result.h"
#include "pathgen/passes.h"
#include "pathgen/plan.h"

namespace tiltfeed {

/// Adds a warning for each reason: how many points, which facets, what to change.
/// Errors: kLimit or kUnreachable when nothing is left.
Result<void> report_refusals(const ClSurface& surface, const Passes& passes, PlanReport& report);

}  // namespace tiltfeed
