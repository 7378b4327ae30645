#pragma once
// Follows the executed tool along the planned path, forwards only, and measures how far the two are apart.

#include <cstdint>
#include <vector>

#include "kinematics/basics/tool_path.h"

namespace tiltfeed::sim {

/// Where on the planned path an executed pose belongs, and how far from it it is.
struct PathPlace {
  std::uint32_t move = 0;  ///< index into ToolPath::moves
  double distance = 0.0;   ///< of the executed tip from the planned path there, mm
  double angle = 0.0;      ///< between the executed and the planned axis, rad
};

/// (V4) A pose counts as a point in six dimensions: the tip and a second point kArm up the axis. The place of
/// a pose is sought from the place of the pose before it onwards; places further along than the tool has
/// moved cost more, so that a path that turns back on itself is not cut short.
class PathMatching {
 public:
  /// Requires: `planned` outlives the walk and has at least one move.
  explicit PathMatching(const ToolPath& planned);

  /// The next executed pose. Poses must be dense: between two of them the tool moves in a straight line.
  PathPlace step(const Pose& executed);

  /// Distance of the planned end of each move from the executed tip's track, kInfinity where the walk has
  /// not come by, mm.
  const std::vector<double>& visited() const { return visited_; }

 private:
  struct Match {
    std::uint32_t move = 0;
    double fraction = 0.0;  ///< of that move
    double cost = 0.0;
  };
  Match seek(const Pose& executed, double moved) const;

  const ToolPath& planned_;
  std::vector<double> visited_;
  std::uint32_t move_ = 0;
  double fraction_ = 1.0;
  Pose before_;
  bool started_ = false;
};

}  // namespace tiltfeed::sim
