#pragma once
// Faces of the part that the tool keeps off: its whole body, by a distance, on every move.

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/part_file/part_model.h"

namespace tiltfeed::config {

/// Adds the faces of job.avoid_faces to the job's fixtures, as surfaces of which the outside counts: passes
/// end where the tool would come nearer than job.avoid, and links and directions keep off, too. With other
/// fixtures the larger of both distances holds for all. Nothing without job.avoid_faces. `part` is
/// check_part() of `model`. Errors: kInput: a mesh file, or no face has that name or colour.
Result<void> add_avoided_faces(Job& job, const pathgen::PartModel& model, const pathgen::CheckedMesh& part);

}  // namespace tiltfeed::config
