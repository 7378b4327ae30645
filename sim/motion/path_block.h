#pragma once
// A block as the look-ahead sees it: its way through the axes, measured so that every axis counts in units of
// its own acceleration, and what speed the axes allow on it and over the corner to the next. (M1)..(M4) in
// sim/motion/README.md.

#include <array>

#include "kinematics/machine/machine.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/motion/motion_options.h"
#include "sim/motion/speed_profile.h"

namespace tiltfeed::sim {

using AxisVector = std::array<double, 5>;  ///< X Y Z, tilt, rotary

AxisVector axes_of(const Joints& joints);

/// What a machine's axes can do; kUnlimited where nothing is stated.
struct AxisLimits {
  explicit AxisLimits(const MachineModel& machine);
  AxisVector velocity, acceleration, jerk;  ///< per minute, per s^2, per s^3
};

/// One queued block. Speeds are along the block's own measure (M1): its length per second.
struct PathBlock {
  Block command;
  double length = 0.0;      ///< (M1), s^2; 1 where no acceleration bounds the block (and for a dwell)
  AxisVector direction{};   ///< (M1): axis way over its acceleration and the length
  double programmed = 0.0;  ///< s at 100 % override, 0 for a rapid
  double fastest = 0.0;     ///< s at axis velocities
  bool stands = false;      ///< dwell, M code: the axes stand still before, during and after it
  bool turns = false;       ///< a rotary axis moves
  bool free = false;        ///< nothing bounds its acceleration
  PathLimits limits;        ///< at the overrides in force
  double entry = 0.0;       ///< highest speed at its start from which all that is planned can be obeyed
  double corner = 0.0;      ///< highest speed at its start that the corner to the block before allows
};

/// The block from `from`; `before`: the one queued before it, nullptr when the machine will stand.
PathBlock make_path_block(const Block& command, const Joints& from, const PathBlock* before,
                          const AxisLimits& limits, const MotionOptions& options);

/// (M2) The seconds that a block asks for at 100 %, 0 for a rapid; `way`: of the axes.
double programmed_seconds(const Block& command, const AxisVector& way, const MotionOptions& options);

/// Sets the speed limit for these overrides, percent.
void apply_overrides(PathBlock& block, int feed_percent, int rapid_percent);

}  // namespace tiltfeed::sim
