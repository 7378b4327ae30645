#pragma once
// Whether a profile is that of the machine in the shop: a program that shows it.

#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// A place at which the program stops.
struct CheckStop {
  Joints joints;  ///< as printed
  Pose pose;      ///< of the tool on the part
};
/// Only places within the limits. Errors: kLimit where there is none.
Result<std::vector<CheckStop>> check_stops(const config::MachineProfile& machine, double tool_length,
                                           double height, double aside = 0.0);

/// A short program that holds the tool tip still on the part while the rotaries turn, with a stop at each
/// place and, in comments, where the tip should be and how the tool should lean. Part zero is the point of
/// the rotary table's axis; the tip stays `height` mm above it and `aside` mm along X. Only places within the
/// limits. Errors: kLimit where there is none.
Result<std::string> check_program(const config::MachineProfile& machine, double tool_length, double height,
                                  double aside = 0.0);

}  // namespace tiltfeed::daemon
