#pragma once
// Bounds of z' on the CL surface, to leave out what of shank and holder can never decide. (S7) in
// pathgen/README.md.

#include "pathgen/cl_surface.h"
#include "pathgen/deformation.h"

namespace tiltfeed {

/// No CL point of the patch is higher than this.
double highest_reference(const ClSurface& surface, const Deformation& map, PatchId patch);

/// No CL point of the cutting part is lower than this.
double lowest_reference(const ClSurface& surface, const Deformation& map);

}  // namespace tiltfeed
