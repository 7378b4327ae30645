#pragma once
// `tiltfeed serve`: one machine's jobs from their submission to their last block, until SIGTERM.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Runs in the foreground. SIGTERM, SIGINT: hold, let the machine come to a stand, return. SIGHUP: reads the
/// configuration again. Tells systemd READY, STATUS, WATCHDOG (from the streaming loop while there is a run),
/// RELOADING, STOPPING. Errors: kIo, kInput, kUsage at the start; afterwards everything goes to the log.
Result<void> serve(const std::string& config_path);

}  // namespace tiltfeed::daemon
