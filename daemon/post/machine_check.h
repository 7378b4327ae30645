#pragma once
// Whether a profile is that of the machine in the shop: a program that shows it.

#include <string>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// A short program that holds the tool tip still on the part while the rotaries turn, with a stop at each
/// place and, in comments, where the tip should be and how the tool should lean. Part zero is the point of
/// the rotary table's axis; the tip stays `height` mm above it. Only places within the limits. Errors: kLimit
/// where there is none.
Result<std::string> check_program(const config::MachineProfile& machine, double tool_length, double height);

}  // namespace tiltfeed::daemon
