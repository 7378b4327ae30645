#pragma once
// A solid shows the tool only the outsides of its facets. Where shells cross or fold, a facet's inside can
// lie open to the tool even though every edge has its two facets; then orientation says nothing about where
// the material is.

#include <cstdint>
#include <vector>

#include "pathgen/deformation.h"
#include "pathgen/mesh.h"

namespace tiltfeed {

/// Facets of `mesh` (indices, ascending) that turn their back to the tool although their axis line leaves the
/// part for good there. Found by four rays a facet, past the point, line or circle where that lies ahead,
/// since it may be inside.
std::vector<std::uint32_t> exposed_backs(const Mesh& mesh, const Deformation& deformation);

}  // namespace tiltfeed
