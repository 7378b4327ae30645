#pragma once
// The job's leave to lean near the pole, joined with the planner's check of the tool against the part.

#include "config/job.h"
#include "kinematics/joints/singularity_bend.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

/// Bends the path where `job.axis_tolerance` allows it; nothing is changed where that is 0.
SingularityBendReport bend_near_singularity(const config::Job& job, const pathgen::CheckedMesh& part,
                                            ToolPath& path);

}  // namespace tiltfeed::daemon
