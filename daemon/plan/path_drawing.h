#pragma once
// The program's moves as a viewer draws them: where the tool is at the end of each block, and when.

#include <iosfwd>
#include <vector>

#include "kinematics/joints/joint_path.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// Numbers of a block, float32 in this order: tip x, y, z (part, mm), axis i, j, k (unit, from the tip to the
/// shank), seconds since the first block with accelerations, kind (0 rapid, 1 plunge, 2 cut), seconds of the
/// block itself, words X, Y, Z, tilt, rotary (mm, degrees).
inline constexpr std::size_t kDrawnNumbers = 14;

/// One record of kDrawnNumbers for each block, little-endian. `durations`: of each block, s; `begin`: when
/// the first begins, s. Returns when the last ends.
/// Property: the poses are those that the blocks' joints command, to the precision of float32.
double write_path_drawing(const JointPath& joints, const std::vector<double>& durations,
                          const MachineModel& machine, const Setup& setup, double begin, std::ostream& out);

}  // namespace tiltfeed::daemon
