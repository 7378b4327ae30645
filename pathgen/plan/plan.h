#pragma once
// The stages in order: mesh -> CL surface -> flat space -> slices -> upper envelope -> passes -> tool path.

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"

namespace tiltfeed::pathgen {

/// Properties: 1 on all of every cutting move the tool gouges by at most `tolerance`, 2 and its cutting end
/// is within `tolerance` of the part. 3 Once retracted, rapids clear it by `clearance` - `tolerance` or more.
/// Errors: kMesh, kLimit, kUnreachable, kGouge: what, which facets, what to change.
Result<Plan> plan(const CheckedMesh& part, const PlanOptions& options, const Progress& progress);

}  // namespace tiltfeed::pathgen
