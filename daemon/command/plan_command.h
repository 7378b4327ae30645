#pragma once
// `tiltfeed plan`: shows how far it is, and what came of it.

#include <string>

#include "daemon/plan/plan_program.h"

namespace tiltfeed::daemon {

/// `progress`: file that holds stage and percentage while it plans; may be empty. The exit status.
int plan_command(const PlanFiles& files, bool each, const std::string& progress);

}  // namespace tiltfeed::daemon
