#pragma once
// Which way the facets face: repair of turned facets (CGAL) and of shells that are inside out.

#include <cstdint>
#include <optional>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/topology.h"

namespace tiltfeed::pathgen {

/// Turns facets over until neighbours agree, as few as possible in each shell (of two equal choices the one
/// that keeps the shell's first facet). Vertices, order and corners stay. Returns the facets turned over,
/// ascending; nothing, and the mesh as it was, when no choice makes all neighbours agree (a Moebius strip).
/// Requires: no facet has a vertex twice.
std::optional<std::vector<std::uint32_t>> orient_facets(Mesh& mesh);

/// The shells that were inside out.
struct InsideOut {
  std::vector<std::uint32_t> shells;  ///< turned over, ascending
  bool certain = true;                ///< false: too many shells to tell which lie inside which; none turned
};

/// Turns closed shells over so that their normals point out of the material. A shell that no other shell
/// contains must have a positive volume; a shell inside one (a void) is turned with the outermost around it.
/// Requires: every edge is sound.
InsideOut turn_outward(Mesh& mesh, const Shells& shells);

}  // namespace tiltfeed::pathgen
