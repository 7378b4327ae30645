#pragma once
// The far side: an axis line may run on past the point, line or circle (inside work), or past the axis of
// Theta (inner half of a circle, outside work), into a part of the flat space that is not its own column.
// What of the tool is there is checked by rays. (F1) in pathgen/linking/README.md.

#include <cstdint>
#include <memory>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/linking/clearance.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed {

class FarSide {
 public:
  /// `clearance_z`: z' of the clearance surface, to which the tool must be able to retract.
  FarSide(const Mesh& mesh, const Deformation& deformation, const PlanOptions& options, double clearance_z);

  /// Cuts out of the passes every point from where the tool could not retract without hitting the far side.
  /// Returns how many. When the user stops it, points are left that should not be.
  std::uint64_t trim(std::vector<std::vector<Pass>>& lines, const ReportShare& report = {});

  /// Is a straight rapid from one pose to the next free of hits on the far side?
  bool travel_clear(const Pose& from, const Pose& to);

 private:
  /// A piece of the tool as a cylinder: heights over the CL reference, mm.
  struct Cylinder {
    double from = 0.0, to = 0.0, radius = 0.0;
    std::unique_ptr<Clearance> clearance;  ///< made when first needed
  };
  Point<Part> reference_of(const Pose& pose) const;
  bool is_astray(const Pose& pose) const;
  bool stands_in_part(const Pose& pose);
  bool blocked(Point<Part> reference, Vec3 axis, double column, double travel);

  bool beyond_part(Point<Part> from, Point<Part> to, double radius) const;

  const Mesh& mesh_;
  Point<Part> low_, high_;  ///< corners of the box round the part
  const Deformation& map_;
  std::vector<Cylinder> tool_;
  double reach_ = 0.0;  ///< of the tool's upper end over the CL reference, mm
  double clearance_z_, reference_height_, thinnest_;
};

}  // namespace tiltfeed
