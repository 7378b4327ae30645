#pragma once
// From loose corners to a mesh: equal corners become one vertex, facets that add no surface are dropped.

#include <cstdint>
#include <vector>

#include "pathgen/mesh.h"
#include "pathgen/stl.h"

namespace tiltfeed {

/// Facets lower than this over their longest edge count as without area, mm: corners in one line that were
/// rounded to float32 on a 10 mm part stand this high, and a thousandth of a fine tolerance is no surface.
inline constexpr double kMinHeight = 1e-6;

/// Some facets, told by their number in the file.
struct Found {
  std::uint64_t count = 0;
  std::uint32_t first = 0;  ///< facet of the STL
};

struct Welded {
  /// Vertices are numbered by their first use; every one is used. Facets have three different vertices.
  Mesh mesh;
  /// Facets of `mesh` without area that yet join their neighbours edge to edge (they seam a T-junction):
  /// needed to tell that the mesh is closed, ascending. No other facet lacks area.
  std::vector<std::uint32_t> seams;
  Found degenerate;  ///< seams included
  Found duplicate;
};

/// Welds by exact equality of coordinates (-0 is 0). Requires: coordinates are finite.
Welded weld(const Stl& stl);

/// Removes the facets listed (ascending) and the vertices that then are unused; keeps all order.
void remove_facets(Mesh& mesh, const std::vector<std::uint32_t>& facets);

}  // namespace tiltfeed
