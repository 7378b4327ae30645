#pragma once
// A job whose files lie elsewhere than its text says.

#include "config/job.h"

namespace tiltfeed {

/// Empty: as the job says.
struct JobFiles {
  std::string stl, machine;
};
/// Errors: as load_job.
Result<Job> load_job_with(const std::string& path, const JobFiles& files);

}  // namespace tiltfeed
