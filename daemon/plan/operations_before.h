#pragma once
// Which operations are planned by what those before them leave.

#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Is the operation planned by what those before it leave? So it is where it asks for `rest`, and where the
/// job states the blank: then rapids keep off what stands.
bool knows_others(const config::Job& job);

/// Of the job at `path` those before `wanted`, if it is planned alone and knows_others(); else none. Their
/// tolerance is what arcs leave of it, as that of all that are planned. Errors: as config::load_operations.
Result<std::vector<config::Job>> operations_before(const std::string& path, const config::JobFiles& files,
                                                   const config::Job& wanted);

}  // namespace tiltfeed::daemon
