#pragma once
// Where the control shifts the tool to a side of its way (CUTCOM/): the plane in which it does so, and the
// words that mean the side of the CL text there.

#include <optional>
#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"
#include "kinematics/cl_text/apt_operation.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// The machine axis that a tool lies along, seen from its tip to its shank.
struct ShiftPlane {
  int code = 17;          ///< G17 X Y, tool along Z; G18 Z X, along Y; G19 Y Z, along X
  bool backward = false;  ///< along the negative axis: the control's left is the tool's right
  bool operator==(const ShiftPlane&) const = default;
};

/// Nothing where the tool is along none of the three axes.
std::optional<ShiftPlane> shift_plane(const MachineModel& machine, const Setup& setup, const Joints& joints);

/// The events of `op` as the control is to be told: kPlane round each kCutterLeft, kCutterRight and
/// kCutterOff that works in another plane than X Y, sides as that plane has them. `joints` are those of its
/// moves, `tool` its number. Errors: coolant through the spindle that the profile has no words for; the
/// dialect has no words for it, a rotary turns, the tool is along no axis of the machine, or along one in
/// whose plane the control does not shift it.
Result<std::vector<PathEvent>> control_events(const AptOperation& op, const JointPath& joints,
                                              const config::MachineProfile& machine, const Setup& setup,
                                              int tool, const std::string& name);

}  // namespace tiltfeed::daemon
