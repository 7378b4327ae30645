#pragma once
// What can be wrong with a path for a machine, where, and what to change.

#include <cstddef>
#include <string>

#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// Two axes nearer to opposite than this (rad) have no great circle between them.
inline constexpr double kOpposite = 1e-6;

/// The letter of the axis whose broken limit a message names; 0 for other messages.
char limited_axis(const std::string& text);

/// Whether the word of a linear axis (X, Y, Z) at this pose changes when the part is moved on the table.
bool part_zero_helps(char letter, const Pose& pose, const MachineModel& machine, const Setup& setup);

/// The error with the move's index and pose in front and, for a broken limit, what to change behind.
Error located(const Error& error, std::size_t index, const Pose& pose, const MachineModel& machine,
              const Setup& setup);

/// Errors: kInput: no moves, a speed or feed that is 0, an axis that is not unit or turns over within a move.
Result<void> check_path(const ToolPath& path, const MachineModel& machine, const JointPathOptions& options);

/// Some move's axis turns over by 180 degrees exactly, which gives it no way.
bool turns_over(const ToolPath& path);

}  // namespace tiltfeed
