#pragma once
// How a simulated control plans its speeds; the limits of its axes are in MachineModel.

#include <cstddef>

#include "config/machine_profile.h"

namespace tiltfeed::sim {

struct MotionOptions {
  std::size_t look_ahead = 0;  ///< blocks planned ahead, the running one included; 0: all that are queued
  double corner_time = 0.005;  ///< s; an axis may change its speed at a corner by its acceleration times this
  bool blend_rotary =
      true;  ///< false: a stop at both ends of every block that turns a rotary axis (LinuxCNC)
  bool feed_over_all_axes =
      false;                     ///< G94: F over the way of all axes, mm and degrees alike (Grbl), not X Y Z
  double mm_per_degree = 1.0;    ///< of that way
  bool still_takes_slot = true;  ///< false: a move without way takes no slot of the planner (Grbl, Marlin)
  bool begins_on_top = false;    ///< Z at the upper end of its travel, as after homing; else at zero
};

/// What the profile states; G94 as its dialect reads it.
MotionOptions motion_options(const config::MachineProfile& profile);

}  // namespace tiltfeed::sim
