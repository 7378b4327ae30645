#pragma once
// The stages in order: mesh -> CL surface -> flat space -> slices -> upper envelope -> passes -> tool path.

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"

namespace tiltfeed::pathgen {

/// Properties: no gouge over `tolerance` by ball or shank, contact within `tolerance`, on every point of
/// every cutting move; rapids clear the part by at least `clearance` - tolerance once retracted.
/// Errors: kMesh, kLimit, kUnreachable, kGouge: what, which facets, what to change.
Result<Plan> plan(const CheckedMesh& part, const PlanOptions& options, const Progress& progress);

}  // namespace tiltfeed::pathgen
