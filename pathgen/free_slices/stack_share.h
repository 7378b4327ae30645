#pragma once
// Of the CL surface's patches those that a stack of planes has to cut. (N7) in pathgen/free_slices/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/free_slices/cl_sections.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// Does a place with this surface normal belong to the stack of options.free.plane_normals[stack]? It is the
/// one whose normal is furthest from the surface's, the first of equals.
bool owned_by(std::uint32_t stack, Vec3 normal, const PlanOptions& options);

/// A flag for each patch: may it have places of the stack's, in the containment, or places within `margin`
/// (mm) of such? Others need not be cut.
std::vector<std::uint8_t> stack_share(const ClSections& sections, std::uint32_t stack,
                                      const PlanOptions& options, double margin);

}  // namespace tiltfeed::pathgen
