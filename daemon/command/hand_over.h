#pragma once
// Subcommands that other programs carry out, which stand beside this one: `verify`, so that what judges a job
// shares neither post nor planner with what made it, and `desk`, so that no page can disturb a run.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Replaces this process by PROGRAM WORDS... ARGUMENTS... from this program's own folder: its output and exit
/// status become ours. Returns only on an error: kIo: it is not there or does not start.
Error hand_over(const std::string& program, const std::vector<std::string>& words,
                const std::vector<std::string>& arguments);

}  // namespace tiltfeed::daemon
