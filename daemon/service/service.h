#pragma once
// `tiltfeed serve`: one machine's jobs from their submission to their last block, until SIGTERM.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Runs in the foreground. SIGTERM, SIGINT: hold, let the machine come to a stand, return. Tells systemd
/// READY, STATUS, WATCHDOG (from the streaming loop while there is a run), RELOADING, STOPPING.
/// Properties: 1 READY is said when requests are answered. 2 WATCHDOG comes within the time that systemd
/// grants, whatever the service does. 3 SIGHUP reads the configuration again; a bad one changes nothing.
/// 4 Over the Modbus ring a job that SIGTERM or kill -9 cut off goes on by `resume`, each block once and in
/// order. 5 After any end nothing starts or resumes without an operator.
/// `version`: of this program; plans of another are not taken.
/// Errors: kIo, kInput, kUsage at the start; afterwards everything goes to the log.
Result<void> serve(const std::string& config_path, const std::string& version);

}  // namespace tiltfeed::daemon
