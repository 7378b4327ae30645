#pragma once
// Approach to the first pose and retract from the last, from a safe height.

#include <optional>
#include <string>

#include "kinematics/cl_text/apt_file.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// The operation with a rapid along the tool axis down to its first pose and up from its last, where these
/// are lower than `clear_height` mm along `rotary_up` above part zero; its events and lines stay with their
/// moves. A tool that lies flatter than kLeastRise has no way up along its axis: that end is left as it is.
AptOperation with_safe_approach(AptOperation operation, const MachineModel& machine, const Setup& setup,
                                double clear_height);

/// Of an operation whose joints break a limit: why the travels do not let the tool rise along its axis to the
/// clear height from the operation's first or last pose, how high they let it rise, and what to do; with the
/// line of the CL text. Nothing where they do, or where they do not reach the pose either.
std::optional<std::string> out_of_travel_at_ends(const AptOperation& operation, const MachineModel& machine,
                                                 const Setup& setup, double clear_height);

/// The operation on the path that `joints` took with its reconfigurations; itself where there are none.
AptOperation reconfigured(AptOperation operation, const JointPath& joints);

}  // namespace tiltfeed
