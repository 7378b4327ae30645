#pragma once
// `tiltfeed send` before a tool change of the program: parked, the operator asked, led back.

#include <functional>
#include <iosfwd>
#include <string>

#include "config/machine_profile.h"
#include "daemon/stream/stream.h"

namespace tiltfeed::daemon {

/// Over a wire that no run is on; `ended`: the operator wants no more. Returns when the machine stands at the
/// place where the program goes on, with what of it is in force. Errors: kCancelled: the operator ended the
/// run; nothing after the change has left.
Result<void> change_in_program(const std::string& program, const ToolChange& change,
                               const config::MachineProfile& machine, const LinkSpec& spec, Link& wire,
                               Clock& clock, const std::function<bool()>& ended, std::istream& in,
                               std::ostream& out);

}  // namespace tiltfeed::daemon
