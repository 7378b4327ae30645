#pragma once
// The simulated machine's own forward kinematics: a chain of frames (bed, table, part; bed, head, tool).
// Independent of kinematics/machine/machine.cpp, so that each checks the other.

#include "kinematics/machine/machine.h"

namespace tiltfeed::sim {

/// The chain of one machine and setup.
class FrameChain {
 public:
  FrameChain(const MachineModel& machine, const Setup& setup);

  /// Tool tip and axis in part coordinates for these axis words.
  Pose operator()(const Joints& joints) const;

 private:
  Structure structure_;
  RotaryAxis rotary_, tilt_;
  Vec3 spindle_, between_, centre_, part_zero_, pivot_to_tip_;
  Rotation fixture_;
};

/// The same for one set of words.
Pose forward_by_frames(const MachineModel& machine, const Setup& setup, const Joints& joints);

}  // namespace tiltfeed::sim
