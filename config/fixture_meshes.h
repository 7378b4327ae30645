#pragma once
// The fixtures of a job as planning keeps clear of them: closed meshes in part coordinates, and how far off.

#include <memory>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/options/fixtures.h"

namespace tiltfeed::config {

/// Null without fixtures. Round bodies are enclosed by flat sides, never cut into. Errors: those of their STL
/// files, led by the job's path and the fixture's name.
Result<std::shared_ptr<const pathgen::Fixtures>> fixture_meshes(const Job& job);

/// The profile's clearances of cutter, shank and holder on rapids, and what a path may stray.
pathgen::FixtureRoom fixture_room(const Job& job);

}  // namespace tiltfeed::config
