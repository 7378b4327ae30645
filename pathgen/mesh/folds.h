#pragma once
// Where a closed mesh is folded over itself and turned inside out.

#include <cstdint>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/topology.h"

namespace tiltfeed {

/// A facet at each edge that looks like a narrow notch (concave, narrower than a right angle) and has no
/// material behind it; ascending. Of more such edges than kMostFoldLooks facets allow only some are asked,
/// evenly spread. Requires: the mesh is closed and oriented.
std::vector<std::uint32_t> folded_facets(const Mesh& mesh);

/// Edges that are asked times facets of the mesh, at most; 16 edges are always asked.
inline constexpr std::size_t kMostFoldLooks = 5'000'000;

}  // namespace tiltfeed
