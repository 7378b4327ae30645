#pragma once
// The CL surface in its flat space, ready to be asked for heights.

#include <memory>
#include <string>
#include <vector>

#include "kinematics/result.h"
#include "pathgen/cl_surface.h"
#include "pathgen/deformation.h"
#include "pathgen/flat_index.h"
#include "pathgen/mesh.h"
#include "pathgen/plan_options.h"

namespace tiltfeed {

struct ClField {
  ClSurface surface;
  Deformation deformation;
  FlatIndex index;
};

/// Offsets and deforms the part for one axis field. Where facets show the tool their inside, both sides of
/// all count as surface, with a warning. Errors: kUnreachable when nothing faces the tool.
Result<std::unique_ptr<const ClField>> make_field(const CheckedMesh& part, const PlanOptions& options,
                                                  std::vector<std::string>& warnings);

}  // namespace tiltfeed
