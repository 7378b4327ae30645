#pragma once
// The blank of a job as the solid that the planner takes.

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed::config {

/// Sets job.plan.blank, and job.plan.from_blank for the first operation; nothing where the job has no blank.
/// Errors: of the file as read_stl(); kMesh: it is not closed; kInput: the part sticks out of it.
Result<void> add_blank(Job& job, const pathgen::CheckedMesh& part);

}  // namespace tiltfeed::config
