#pragma once
// The far side: an axis line may run on past the point, line or circle (inside work), or past the axis of
// Theta (inner half of a circle, outside work), into a part of the flat space that is not its own column.
// What of the shank is there is checked by rays. (F1) in pathgen/README.md.

#include <cstdint>
#include <memory>
#include <vector>

#include "kinematics/tool_path.h"
#include "pathgen/clearance.h"
#include "pathgen/cutter.h"
#include "pathgen/deformation.h"
#include "pathgen/envelope.h"

namespace tiltfeed {

class FarSide {
 public:
  /// `clearance_z`: z' of the clearance surface, to which the tool must be able to retract.
  FarSide(const Mesh& mesh, const Deformation& deformation, const Cutter& cutter, double allowance,
          double clearance_z);

  /// Cuts out of the passes every point from where the tool could not retract without its shank hitting the
  /// far side. Returns how many.
  std::uint64_t trim(std::vector<std::vector<Pass>>& slices);

  /// Is a straight rapid from one pose to the next free of hits on the far side?
  bool travel_clear(const Pose& from, const Pose& to);

 private:
  bool blocked(Point<Part> centre, Vec3 axis, double length);

  const Mesh& mesh_;
  const Deformation& map_;
  double radius_, reach_, clearance_z_;
  double ball_radius_;
  std::unique_ptr<Clearance> clearance_;  ///< made when first needed
};

}  // namespace tiltfeed
