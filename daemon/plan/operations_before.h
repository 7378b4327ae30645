#pragma once
// Which operations are planned only for what they leave to another.

#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Of the job at `path` those before `wanted`, if it is planned alone and cuts only what they leave; else
/// none. Their tolerance is what arcs leave of it, as that of all that are planned. Errors: as
/// config::load_operations.
Result<std::vector<config::Job>> operations_before(const std::string& path, const config::JobFiles& files,
                                                   const config::Job& wanted);

}  // namespace tiltfeed::daemon
