#pragma once
// The simulated machine's own forward kinematics: a chain of frames (bed, table, part; bed, head, tool),
// multiplied out. Independent of kinematics/machine.cpp, so that each checks the other.

#include "kinematics/machine.h"

namespace tiltfeed::sim {

/// Tool tip and axis in part coordinates for these axis words.
Pose forward_by_frames(const MachineModel& machine, const Setup& setup, const Joints& joints);

}  // namespace tiltfeed::sim
