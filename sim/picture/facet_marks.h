#pragma once
// Which facets of a part a path leaves: those that the planner says it cannot reach, and those that no cut
// comes near.

#include <cstdint>
#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::sim {

enum class FacetMark : std::uint8_t { kNone, kUncut, kUnreached };

/// Of each facet of the mesh. `report`: the planner's, JSON text; empty: none is known. Unreached: among its
/// free.unreached_facets. RestReason: by half at least among its uncut.facets; with the axis free, balls and
/// taper balls, where more is left in the facet's middle than the ridge between two passes that lie one side
/// step apart where planes cut the surface at 45 degrees. Errors: kInput: the report is not one.
Result<std::vector<FacetMark>> facet_marks(const pathgen::Mesh& part, const config::Job& job,
                                           const ToolPath& path, const std::string& report);

}  // namespace tiltfeed::sim
