#pragma once
// The part of a job, from whatever file: STL, OBJ, PLY, 3MF, STEP, IGES, told apart by content.

#include <map>
#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/part_file/part_model.h"

namespace tiltfeed::config {

/// What of a file is taken, and how finely.
struct PartRequest {
  std::string path;
  double unit_mm = 1.0;                  ///< of a mesh file; other files state their own
  std::vector<std::string> bodies = {};  ///< by name; empty: all
  double deviation = 0.002;              ///< largest distance of facets from surfaces (STEP, IGES), mm
};

/// Errors: as read_stl(), read_three_mf() and run_cad(); kInput: a unit is given for a file that states its
/// own, a body is not there. kCancelled.
Result<pathgen::PartModel> read_part_file(const PartRequest& request,
                                          const pathgen::ReportShare& report = {});

/// The job's part, whose facets leave the surfaces by their share of the tolerance at most. Every program
/// that has to do with a job reads it here, and finds the same facets. Errors: as read_part_file().
Result<pathgen::PartModel> read_part_model(const Job& job, const pathgen::ReportShare& report = {});
/// Checked and repaired within its share of the tolerance: source[i] of the mesh is an index into face_of.
/// Takes the facets out of `model`. Errors: as check_mesh().
Result<pathgen::CheckedMesh> check_part(const Job& job, pathgen::PartModel& model,
                                        const pathgen::ReportShare& report = {});
/// Both.
Result<pathgen::CheckedMesh> read_part(const Job& job, const pathgen::ReportShare& report = {});

/// The parts of a job's operations, each as its tolerance lets it be repaired and read once.
class PartsByTolerance {
 public:
  /// It stays where it is. Errors: as read_part().
  Result<const pathgen::CheckedMesh*> of(const Job& job, const pathgen::ReportShare& report = {});
  /// The model of what of() gives, without facets. Requires: of() has been asked for a job of that tolerance.
  const pathgen::PartModel& model_of(const Job& job) const { return parts_.at(job.plan.tolerance).model; }

 private:
  struct Part {
    pathgen::CheckedMesh mesh;
    pathgen::PartModel model;
  };
  std::map<double, Part> parts_;
};

}  // namespace tiltfeed::config
