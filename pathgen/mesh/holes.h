#pragma once
// Holes: closed loops of open edges, and which of them are facets that went missing.

#include <cstdint>
#include <string>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/topology.h"

namespace tiltfeed::pathgen {

/// A hole is taken for one or two missing facets, and filled, where
/// 1 its rim has at most kMaxHoleEdges edges. It is then at most twice as wide as the longest edge of the
/// facets
///   beside it, and its fill stands off the true surface about as far as two such facets do;
/// 2 each facet of the fill goes on from a facet beside it, turned by kMaxHoleTurnDegrees at most. The end of
///   a tube and the open top of a box turn by far more on all sides; a mesh that turns by more from facet to
///   facet is too coarse to tell the two apart.
inline constexpr std::size_t kMaxHoleEdges = 4;
inline constexpr double kMaxHoleTurnDegrees = 30.0;

/// Corner i and the next (cyclic) are an edge of facet beside[i], which runs along it the other way: a fill
/// whose facets run in this order agrees with the facets beside it.
struct Hole {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> beside;
};

/// The holes, in the order of their lowest corner; where several meet in a corner, each is closed as soon as
/// it can be. Open edges that lead round no loop (neighbours that disagree) are in none.
std::vector<Hole> find_holes(const VertexFans& fans);

/// The largest distance of two corners, mm. Requires: at most kMaxHoleEdges corners.
double width(const Mesh& mesh, const Hole& hole);

struct Fill {
  std::vector<Facet> facets;  ///< on the hole's corners; of all that fit, those that turn least
  std::string obstacle;       ///< not empty: the rule that keeps the hole open, and where
};
Fill fill(const Mesh& mesh, const Hole& hole);

}  // namespace tiltfeed::pathgen
