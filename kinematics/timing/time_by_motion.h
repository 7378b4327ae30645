#pragma once
// Where a program's minutes go: what its time is made of, by kind of motion. (K17).

#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// Seconds. Their sum is the time of all blocks.
struct TimeByMotion {
  double cuts_at_feed = 0.0;   ///< cuts, if the tip kept their feed
  double slow_axes = 0.0;      ///< what cuts take longer as an axis is at its velocity
  double accelerations = 0.0;  ///< and what they take longer as the axes speed up and slow down
  double plunges = 0.0;
  double rapids = 0.0;  ///< of which a slide is the slowest axis
  double swings = 0.0;  ///< rapids of which a rotary is the slowest axis

  void add(const TimeByMotion& more);
};

/// `moves`: the joints of `path`; `durations`: what each block takes, s (Timing::durations). Requires: as
/// many of both. Properties: 1 The sum of all is that of the durations, to rounding. 2 None is negative where
/// no block is faster than programmed.
TimeByMotion time_by_motion(const ToolPath& path, const std::vector<JointMove>& moves,
                            const std::vector<double>& durations, const MachineModel& machine);

}  // namespace tiltfeed
