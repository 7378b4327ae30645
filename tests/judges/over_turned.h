#pragma once
// How fast the tool axis turns on the passes of a path, against its limit.

#include <algorithm>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed {
using namespace pathgen;

/// By how much (rad) the axis turns faster on a pass than it may, at the most; below 0: by how much it keeps
/// within. CL points lie the ball's centre over the tip.
inline double over_turned(const PlanOptions& o, const std::vector<Move>& moves) {
  double most = -kPi;
  const auto centre = [&](const Pose& p) { return p.tip + p.axis * o.cutter.radius(); };
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Pose &a = moves[i - 1].pose, &b = moves[i].pose;
    if (moves[i].kind == MoveKind::kCut)
      most = std::max(
          most, angle_between(a.axis, b.axis) - o.free.max_turn.radians() * distance(centre(a), centre(b)));
  }
  return most;
}

}  // namespace tiltfeed
