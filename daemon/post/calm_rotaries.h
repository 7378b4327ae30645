#pragma once
// The job's leave to lean for even turns, joined with the planner's check of the tool against the part.

#include "config/job.h"
#include "kinematics/joints/calm_axes.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

/// Calms the path's axes within `job.calm`; nothing is changed, nor told, where that is 0. `progress` as
/// calm_axes() has it. Errors: kCancelled; the path is as it was.
Result<CalmReport> calm_rotaries(const config::Job& job, const pathgen::CheckedMesh& part, ToolPath& path,
                                 const StageProgress& progress);

}  // namespace tiltfeed::daemon
