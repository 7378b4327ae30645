#pragma once
// The CL surface in its flat space, ready to be asked for heights.

#include <memory>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/cl_surface.h"
#include "pathgen/surface/flat_index.h"

namespace tiltfeed::pathgen {

struct ClField {
  ClSurface surface;
  Deformation deformation;
  FlatIndex index;
  FlatBounds bounds;  ///< of what the cutting part can reach
  /// The part is closed, and what the tool comes from may lie in its material: (E1), leave_material().
  bool starts_inside = false;
  std::shared_ptr<const Mesh> mesh{};  ///< of part and fixtures; null: the part's own, without fixtures
};

/// Offsets the part by the cutting part of the tool and deforms it for one axis field. Where facets show the
/// tool their inside, both sides of all count as surface, with a warning. Errors: kUnreachable when nothing
/// faces the tool; kCancelled. With fixtures their patches stand beside the part's, (C7).
Result<std::unique_ptr<const ClField>> make_field(const CheckedMesh& part, const PlanOptions& options,
                                                  std::vector<std::string>& warnings,
                                                  const ReportShare& report = {});

/// Hulls are not split below this size (mm): there the point, line or circle is inside or next to them.
double smallest_hull(const PlanOptions& options);

}  // namespace tiltfeed::pathgen
