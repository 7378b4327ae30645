#pragma once
// Whether a machine, with the part set up on it, brings the tool to a pose.

#include <optional>

#include "kinematics/basics/tool_path.h"
#include "kinematics/machine/chain.h"
#include "kinematics/machine/machine.h"
#include "pathgen/reach/reach.h"

namespace tiltfeed::pathgen {

class MachineReach {
 public:
  MachineReach(const MachineModel& machine, const Setup& setup) : machine_(machine), chain_(machine, setup) {}

  /// kTilt where no rotary angles within their limits give the axis; kTravel where some do, and X Y Z are
  /// beyond their travels with all of them; else nothing. Safe to call from several threads.
  std::optional<Reach> refusal(const Pose& pose) const;

 private:
  MachineModel machine_;
  Chain chain_;
};

}  // namespace tiltfeed::pathgen
