#pragma once
// A look at a machine that no run is on: where its axes are, and the one order that leads out of every state.

#include <optional>
#include <string>
#include <vector>

#include "daemon/wire/link.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// Where the axes are, as the controller reports it, in program coordinates. Nothing where it does not tell
/// (drip feed, plain drives, a Grbl without offsets or in another one than G54, a RepRap board that restarts
/// when it is asked). Errors:
/// kLink.
Result<std::optional<Joints>> read_place(const LinkSpec& link, const MachineModel& machine, Link& wire,
                                         Clock& clock);

/// Whether the opening of a run would be refused for the state that the machine is in. Errors: kUsage with
/// that state and what leads out of it; kLink.
Result<void> takes_run(const LinkSpec& link, Link& wire, Clock& clock);

/// Registers of a controller, asked for until they come. Errors: kLink.
Result<std::vector<std::uint16_t>> read_registers(Link& wire, std::uint16_t first, std::uint16_t count);

/// What `reset_machine` will do over this link, for the operator who has to agree to it.
std::string reset_preview(const LinkSpec& link);
/// Ends whatever the controller is in (hold, check mode, alarm, a run that nobody feeds): it stands idle, its
/// buffers are empty, spindle and coolant are off. Returns what was reached. Errors: kLink with what was not,
/// and what to do at the machine.
Result<std::string> reset_machine(const LinkSpec& link, Link& wire, Clock& clock);

}  // namespace tiltfeed::daemon
