#pragma once
// Tool axes that turn as evenly as a cone about the planned ones lets them, so that tilt and table need not
// stop and turn back: (K18).

#include <cstddef>

#include "kinematics/basics/result.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/joints/singularity_bend.h"

namespace tiltfeed {

struct CalmOptions {
  Angle cone;                ///< largest angle between a calm axis and the planned one, below 90 degrees
  double tolerance = 0.001;  ///< mm; by how much the ball's centre may leave its planned way between points
};

struct CalmReport {
  std::size_t points = 0;   ///< of the path whose axis leans from the planned one
  std::size_t refused = 0;  ///< moves that were planned calm, and at which the tool is not clear so
  Angle largest;            ///< lean of a point
};

struct CalmPath {
  ToolPath path;  ///< with more points than the planned one where it leans
  CalmReport report;
};

/// Cutting moves with their axes on the shortest way in the cone, timed as the tip moves at its feed. The
/// tip goes along so that the ball's centre (`path.tool.corner_radius` up the axis) stays where it is.
/// Properties: 1 No axis leans by more than the cone. 2 The first and last point of every run of cutting
/// moves are kept. 3 Every move of which an end leans is one that `clear` has accepted. 4 The ball's centre
/// passes its planned places in their order. 5 The same for any number of threads. `progress`: the share of
/// the cutting moves that were checked once, on the calling thread. Requires: a path that check_path accepts,
/// a ball end. Errors: kCancelled.
Result<CalmPath> calm_axes(const ToolPath& path, Vec3 up, const CalmOptions& options, const MoveCheck& clear,
                           const StageProgress& progress = {});

}  // namespace tiltfeed
