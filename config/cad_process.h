#pragma once
// `tiltfeed-cad` as a process of its own: OpenCASCADE may fault, hang or take all memory on a damaged file.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/part_file/part_model.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::config {

/// Of one file: memory, processor time, and time on the clock.
inline constexpr int kCadMemoryMb = 8192, kCadSeconds = 900, kCadWallSeconds = 1800;

/// The facets of a STEP or IGES file, within `allowed` (mm) of its surfaces. Errors: those of the program,
/// which name the entity; kInput where it faults, with what it was at; kLimit where it needs more than it
/// may; kIo where it is not installed; kCancelled.
Result<pathgen::PartModel> run_cad(const std::string& path, const std::vector<std::string>& bodies,
                                   double allowed, const pathgen::ReportShare& report);

/// The same of another program in its place, as tests have it.
Result<pathgen::PartModel> run_cad_program(const std::vector<std::string>& words, const std::string& path,
                                           const pathgen::ReportShare& report, int wall_seconds);

}  // namespace tiltfeed::config
