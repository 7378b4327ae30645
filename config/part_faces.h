#pragma once
// Faces of the part that a job names: those that the tool keeps off, and those that alone are machined.

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/part_file/part_model.h"

namespace tiltfeed::config {

/// Adds the faces of job.avoid_faces to the job's fixtures, as surfaces of which the outside counts: passes
/// end where the tool would come nearer than job.avoid, and links and directions keep off, too. With other
/// fixtures the larger of both distances holds for all. Nothing without job.avoid_faces. `part` is
/// check_part() of `model`. Errors: kInput: a mesh file, or no face has that name or colour; kMesh: nothing
/// is left of one after the repair.
Result<void> add_avoided_faces(Job& job, const pathgen::PartModel& model, const pathgen::CheckedMesh& part);

/// Sets job.plan.only_faces to the faces of job.only_faces; nothing without these. `part` and errors as
/// above; kMesh: nothing is left of all of them.
Result<void> add_chosen_faces(Job& job, const pathgen::PartModel& model, const pathgen::CheckedMesh& part);

}  // namespace tiltfeed::config
