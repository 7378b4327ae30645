#pragma once
// Near the pole the rotary must race to follow the tool axis exactly. Where the job lets the axis lean by
// some angle from the planned one, the path is bent so that the rotary turns slowly: (K13).

#include <cstddef>
#include <functional>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/tool_path.h"
#include "kinematics/basics/units.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// Is the tool clear of the part all along the move from one pose to the next? Called from several threads.
using MoveCheck = std::function<bool(const Pose& from, const Pose& to)>;

struct SingularityBendOptions {
  Angle axis_tolerance;      ///< largest angle between a bent axis and the planned one
  double tolerance = 0.001;  ///< mm; by how much the ball's centre may leave its planned way between points
};

struct SingularityBendReport {
  std::size_t stretches = 0;  ///< bent pieces of passes
  std::size_t points = 0;     ///< of the path whose axis leans from the planned one
  std::size_t refused = 0;  ///< pieces left as they are although the rotary races: the tool is not clear bent
  Angle largest;            ///< lean of a point
};

struct SingularityBend {
  ToolPath path;  ///< with more points than the planned one where it is bent
  SingularityBendReport report;
};

/// Bends cutting moves within kPoleReach axis tolerances of the rotary axis. The axis leans square to its own
/// way, and the tip goes along so that the ball's centre (`path.tool.corner_radius` up the axis) stays where
/// it is. Properties: no axis leans by more than the tolerance; the first and last point of every run of
/// cutting moves are kept, and every point that does not lean; every move of which an end leans is one that
/// `clear` has accepted; a piece is bent only where that lessens the speed that the rotary takes of what it
/// has. The same for any number of threads. Requires: a path that check_path accepts, a ball end, a tolerance
/// above 0.
SingularityBend bend_at_singularity(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                                    const SingularityBendOptions& options, const MoveCheck& clear);

/// So many axis tolerances from the rotary axis a bend changes the rotary's speed by 5 % at most.
inline constexpr double kPoleReach = 20.0;

}  // namespace tiltfeed
