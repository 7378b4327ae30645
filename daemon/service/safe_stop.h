#pragma once
// `tiltfeed safe-stop`: what systemd runs when the service has ended (ExecStopPost=). A service that died
// with a job on the machine leaves it moving and its spindle turning; where the wire has no watchdog of its
// own, this holds the machine and turns spindle and coolant off. It moves nothing and changes no journal.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// How the service ended, as systemd tells by $SERVICE_RESULT, $EXIT_CODE and $EXIT_STATUS; all empty: called
/// by hand.
struct ServiceEnd {
  std::string result, code, status;
};
ServiceEnd service_end();
/// It left by itself, having held the machine. A service that was ended by a signal has not, although systemd
/// calls some signals a success.
bool in_order(const ServiceEnd& end);

/// What was done, for the log; `job` 0: none was on the machine, or the spool cannot tell.
struct SafeStop {
  std::string machine, text;
  std::uint64_t job = 0;
  bool due = false;  ///< something may have been on the machine
};
/// Looks at the spool and the journal of the service and stops its machine if a job was on it, or if they
/// cannot be read. Errors: those of the configuration, the spool and the journal (in use: the service lives;
/// of a later version), the wire and `stop_machine`.
Result<SafeStop> safe_stop(const std::string& config_path, const ServiceEnd& end);

}  // namespace tiltfeed::daemon
