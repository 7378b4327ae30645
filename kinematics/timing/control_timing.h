#pragma once
// How long blocks take on a control that looks ahead and rounds nothing off, its axes limited in acceleration
// and jerk. (K16).

#include <cstddef>
#include <vector>

#include "kinematics/timing/timing.h"

namespace tiltfeed {

/// What the control does between blocks, as the machine profile's section `control` has it.
struct ControlPace {
  double corner_time = 0.005;    ///< s; an axis may change its speed at once by its acceleration times this
  std::size_t look_ahead = 200;  ///< blocks known, the running one among them; 0: all
  double least_seconds = 0.0;    ///< no block at feed takes less: the control's largest F under G93
};

/// Axes start and end the program at rest, and stand where an operation begins; within a block all of them
/// move together. A jerk of 0 is no limit; with one the acceleration is 0 at every block's end. Properties: 1
/// No axis is over its velocity, acceleration or jerk but for what the corners allow. 2 No block is faster
/// than programmed. 3 More look-ahead makes none slower. 4 The same numbers on any number of threads.
Timing time_on_control(const std::vector<JointMove>& moves, const MachineModel& machine,
                       const ControlPace& pace);

}  // namespace tiltfeed
