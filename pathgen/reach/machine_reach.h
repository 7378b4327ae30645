#pragma once
// Whether a machine, with the part set up on it, brings the tool to a pose.

#include <optional>

#include "kinematics/basics/tool_path.h"
#include "kinematics/basics/units.h"
#include "kinematics/machine/chain.h"
#include "kinematics/machine/machine.h"
#include "pathgen/reach/reach.h"

namespace tiltfeed::pathgen {

/// How far a tool may lean from the table's z (setup.tilt_max_deg) with a machine, half a degree within what
/// its tilt gives; 180 where that is not what limits it.
Angle tilt_limit(const MachineModel& machine);

class MachineReach {
 public:
  MachineReach(const MachineModel& machine, const Setup& setup, Angle tilt_max = Angle::from_degrees(180.0));

  /// kTilt where the axis leans further than `tilt_max`, or no rotary angles within their limits give it;
  /// kTravel where some do, and X Y Z are beyond their travels with all of them; else nothing. Safe to call
  /// from several threads.
  std::optional<Reach> refusal(const Pose& pose) const;

 private:
  MachineModel machine_;
  Chain chain_;
  double least_upright_;  ///< cosine of the tilt
};

}  // namespace tiltfeed::pathgen
