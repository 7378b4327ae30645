#pragma once
// `tiltfeed verify`: hands over to the program beside this one that simulates the machine. It is another
// program so that what judges a job shares neither post nor planner with what made it.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed {

/// Replaces this process by `tiltfeed-sim verify ARGUMENTS...` from this program's own folder: its output
/// and exit status become ours. Returns only on an error: kIo: it is not there or does not start.
Error run_verify(const std::vector<std::string>& arguments);

}  // namespace tiltfeed
