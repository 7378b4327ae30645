#pragma once
// The files that a job is made of: no output of a command may be one of them.

#include <vector>

#include "config/job.h"
#include "config/output_file.h"

namespace tiltfeed::config {

/// The job's own, its part, machine, tool library, and the meshes of its fixtures and of the machine's
/// bodies.
std::vector<NamedFile> files_of(const Job& job);

}  // namespace tiltfeed::config
