#pragma once
// Ends what is left on a machine that no run is on any more: held, spindle and coolant off.

#include <string>

#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// Longest time that a stop takes, beside opening the wire: less than the unit's TimeoutStopSec.
inline constexpr Time kSafeStopLimit = std::chrono::seconds(20);

/// Stops what a dead service left on this wire, as far as the controller lets a newcomer. Returns what was
/// reached, for people. Requires: kGrbl, kRepRap or a drive. Errors: kLink with what could not be reached or
/// seen, and what to do at the machine.
Result<std::string> stop_machine(const LinkSpec& link, Link& wire, Clock& clock);

}  // namespace tiltfeed::daemon
