#include "daemon/plan/operations_before.h"

#include <algorithm>

namespace tiltfeed::daemon {

bool knows_others(const config::Job& job) { return job.plan.rest_more_than > 0.0 || job.blank.has_value(); }

Result<std::vector<config::Job>> operations_before(const std::string& path, const config::JobFiles& files,
                                                   const config::Job& wanted) {
  if (files.operation.empty() || !knows_others(wanted)) return std::vector<config::Job>{};
  config::JobFiles all = files;
  all.operation.clear();
  auto jobs = config::load_operations(path, all);
  if (!jobs) return jobs;
  jobs->erase(std::find_if(jobs->begin(), jobs->end(),
                           [&](const config::Job& job) { return job.operation.name == files.operation; }),
              jobs->end());
  for (config::Job& job : *jobs) job.plan.tolerance -= job.program.arc_tolerance;
  return jobs;
}

}  // namespace tiltfeed::daemon
