#pragma once
// What a job's part leaves clear about itself, for the post.

#include "config/job.h"
#include "kinematics/joints/joint_path.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

/// Over the part and beside it, its stock and the job's clearance added; beside it the tool's half width,
/// too. Clamps and fixtures are not known.
ClearSpace part_extent(const pathgen::Mesh& mesh, const config::Job& job);

}  // namespace tiltfeed::daemon
