#pragma once
// Where a machine may be reported: its travels, and how far a report may be off.

#include <array>

#include "config/link_profile.h"
#include "daemon/wire/axis_values.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// How far a report may be off, and how far an axis can go.
struct PositionLimits {
  config::PositionTolerance tolerance = {};
  AxisValues low = no_axes(), high = no_axes();  ///< travel, program coordinates; not a number: not known
  std::array<bool, kMostAxes> modulo = {};       ///< words of this axis count modulo 360: not compared
};
/// Travels of a machine profile; none without one.
PositionLimits position_limits(const config::PositionTolerance& tolerance, const MachineModel* machine);

}  // namespace tiltfeed::daemon
