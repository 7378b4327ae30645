#pragma once
// A path whose moves pass the rotary's pole, with a pose put in there: where the rotary is free it can be
// turned over when a limit of the tilt asks for it.

#include <cstdint>
#include <vector>

#include "kinematics/joints/joint_chooser.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

struct PathOverSingularity {
  ToolPath path;
  std::vector<std::uint32_t> planned;  ///< by move, the move of the path as given in which it ends
  /// By move, what is asked up to the pole that comes next: the branch whose tilt, X, Y or Z would break a
  /// limit before it is barred, unless both would; and how far a rotary with limits turns on either.
  std::vector<WayFromPole> ahead;
  bool changed = false;
};

/// `cone`: half-angle about the pole, rad. `lift`: a rapid over the pole goes by way of the clear height, up
/// and down along its axes. A move whose axis turns over by exactly 180 degrees goes by way of the pole.
/// Requires: with `lift`, clear.height.
PathOverSingularity over_singularity(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                                     const JointChooser& chooser, const ClearSpace& clear, double cone,
                                     bool lift);

}  // namespace tiltfeed
