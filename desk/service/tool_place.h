#pragma once
// Where the tool is on the part while its axes are where the controller says.

#include <map>
#include <optional>
#include <string>

#include "kinematics/machine/machine.h"

namespace tiltfeed::desk {

/// Program coordinates by their letters, "X" and so on; mm and degrees.
using AxisPlaces = std::map<std::string, double>;

/// Tip and axis on the part. Nothing where an axis of the machine is not known.
std::optional<Pose> tool_place(const AxisPlaces& axes, const MachineModel& machine, const Setup& setup);

}  // namespace tiltfeed::desk
