#pragma once
// `tiltfeed safe-stop`: what systemd runs when the service has ended (ExecStopPost=). A service that died
// with a job on the machine leaves it moving and its spindle turning; where the wire has no watchdog of its
// own, this holds the machine and turns spindle and coolant off. It moves nothing and changes no journal.

#include <string>

#include "daemon/link.h"

namespace tiltfeed {

/// How the service ended, as systemd tells by $SERVICE_RESULT, $EXIT_CODE and $EXIT_STATUS; all empty: called
/// by hand.
struct ServiceEnd {
  std::string result, code, status;
};
ServiceEnd service_end();
/// It left by itself, having held the machine. A service that was ended by a signal has not, although systemd
/// calls some signals a success.
bool in_order(const ServiceEnd& end);

/// Longest time that a stop takes, beside opening the wire: less than the unit's TimeoutStopSec.
inline constexpr Time kSafeStopLimit = std::chrono::seconds(20);

/// Stops what a dead service left on this wire, as far as the controller lets a newcomer. Returns what was
/// reached, for people. Requires: kGrbl, kRepRap or a drive. Errors: kLink with what could not be reached or
/// seen, and what to do at the machine.
Result<std::string> stop_machine(const LinkSpec& link, Link& wire, Clock& clock);

/// What was done, for the log; `job` 0: there was nothing to stop.
struct SafeStop {
  std::string machine, text;
  std::uint64_t job = 0;
};
/// Looks at the spool and the journal of the service and stops its machine if a job was on it. Errors: those
/// of the configuration, the spool, the journal (in use: the service lives), the wire and `stop_machine`.
Result<SafeStop> safe_stop(const std::string& config_path, const ServiceEnd& end);

}  // namespace tiltfeed
