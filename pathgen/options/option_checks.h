#pragma once
// What a plan's options must be, whoever made them.

#include "kinematics/basics/result.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// Errors: kInput with the job's key and what it must be.
Result<void> check_options(const PlanOptions& o);

}  // namespace tiltfeed::pathgen
