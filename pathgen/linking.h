#pragma once
// Passes of the envelope to one tool path: order, direction, and the moves through clear air between them.

#include <vector>

#include "kinematics/result.h"
#include "kinematics/tool_path.h"
#include "pathgen/envelope.h"

namespace tiltfeed {

enum class Direction { kOneWay, kZigzag };

struct LinkOptions {
  Direction direction = Direction::kZigzag;
  double ball_radius = 0.0;  ///< of the tool, without allowance, mm
  double clearance = 0.0;    ///< from the highest envelope point to the clearance surface, mm
  double approach = 0.0;     ///< last part of an approach, at plunge feed, mm
};

/// The moves over all passes, slice by slice. Between passes the tool retracts along its axis to the
/// clearance surface (constant z', `clearance` above the highest point of all), travels there, comes down
/// along the new axis, and plunges the last `approach`. (L1), (L2) in pathgen/README.md. Errors: kLimit when
/// the clearance surface would reach the point, line or circle (inside work).
Result<std::vector<Move>> link(const std::vector<std::vector<Pass>>& slices, const ClSurface& surface,
                               const Deformation& deformation, const LinkOptions& options);

}  // namespace tiltfeed
