#pragma once
// A piece of the tool as a smaller convex body, its core, that is grown by a ball: how near the core may come
// to the part is how deep the piece may cut.

#include <vector>

#include "sim/solid/tool_solid.h"

namespace tiltfeed::sim {

/// (P2) All of the piece is within `rounding` of the core; a body whose distance from the core is d cuts the
/// piece no deeper than rounding - d / sharpness, and where d is 0, rounding or more.
struct ToolCore {
  ToolPart part = ToolPart::kCutter;
  double rounding = 0.0;            ///< mm
  double sharpness = 1.0;           ///< 1: the piece is the core grown by a ball
  std::vector<Corner> corners;      ///< `turn` is not used
  double low = 0.0, high = 0.0;     ///< of its axis, above the tip, mm
  double wide = 0.0;                ///< all of it is within this of that axis, mm
  double reach = 0.0;               ///< all of it is within this of the tip, mm
  const Revolved* solid = nullptr;  ///< the piece itself

  /// The furthest point along u, a unit vector, of the core standing at a pose, as seen from the tip.
  Vec3 furthest(Vec3 axis, Vec3 u) const;
};

/// The cores of all pieces of the tool. `depth`: the rounding of pieces that are not round by themselves, mm.
/// `solid` outlives the result.
std::vector<ToolCore> tool_cores(const ToolSolid& solid, double depth);

}  // namespace tiltfeed::sim
