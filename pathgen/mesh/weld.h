#pragma once
// From loose corners to a mesh: equal corners become one vertex, facets that add no surface are dropped.

#include <cstdint>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

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
  VertexFans fans;    ///< of `mesh`
  EdgeSurvey survey;  ///< of all edges of `mesh`
  /// Facets of `mesh` without area that yet join their neighbours edge to edge (they seam a T-junction):
  /// needed to tell that the mesh is closed, ascending. No other facet lacks area.
  std::vector<std::uint32_t> seams;
  Found degenerate;  ///< seams included
  Found duplicate;
};

/// Welds by exact equality of coordinates (-0 is 0); the same for any number of threads. Requires:
/// coordinates are finite. `report`: is told how far it is; its answer is not heeded.
Welded weld(const Stl& stl, const ReportShare& report = {});

/// Facets on the same three vertices as an earlier one, whatever their order; ascending.
std::vector<std::uint32_t> find_duplicates(const Mesh& mesh);

/// The facet's height over its longest edge is above kMinHeight.
bool has_area(const Mesh& mesh, const std::array<std::uint32_t, 3>& facet);

/// The facets for which has_area does not hold, ascending.
std::vector<std::uint32_t> without_area(const Mesh& mesh);

/// Removes the facets listed (ascending) and the vertices that then are unused; keeps all order.
void remove_facets(Mesh& mesh, const std::vector<std::uint32_t>& facets);

}  // namespace tiltfeed::pathgen
