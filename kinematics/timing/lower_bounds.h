#pragma once
// What no motion along a path can undercut, whatever its accelerations: how much of a program's time there is
// to gain. (K15).

#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// Seconds.
struct LowerBounds {
  double path = 0.0;    ///< the tip's way in cuts and plunges, at their feeds
  Joints axes;          ///< each axis's whole way, at its speed
  double blocks = 0.0;  ///< each block by itself, at its feed or at the speed of its slowest axis

  void add(const LowerBounds& more);
  /// The largest of them.
  double most() const;
};

/// `moves`: the joints of `path`. Properties: 1 `blocks` is no less than the others, to 1e-6 of it. 2 The
/// time of the program is no less than any.
LowerBounds lower_bounds(const ToolPath& path, const std::vector<JointMove>& moves,
                         const MachineModel& machine);

}  // namespace tiltfeed
