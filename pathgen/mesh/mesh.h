#pragma once
// The part as a triangle mesh: welded, checked, its defects named.

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/decimal.h"
#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/stl.h"

namespace tiltfeed::pathgen {

struct Box {
  Point<Part> min, max;
};

/// The box with p in it.
inline Box grown(const Box& box, Point<Part> p) {
  return {{std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)},
          {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)}};
}

/// Facet i has corners vertices[facets[i][0..2]], counter-clockwise seen from outside where the mesh is
/// oriented, and came from facet source[i] of the STL file, counting from 0. A facet that fills a hole has
/// the source of a facet beside it.
struct Mesh {
  std::vector<Point<Part>> vertices;
  std::vector<std::array<std::uint32_t, 3>> facets;
  std::vector<std::uint32_t> source;
};

enum class DefectKind {
  kDegenerate,   ///< facets without area: dropped
  kDuplicate,    ///< facets on the same three vertices as an earlier one, whatever their order: dropped
  kOpenEdge,     ///< edges with one facet
  kNonManifold,  ///< edges with more than two facets
  kMisoriented,  ///< edges that their two facets run along in the same direction; repaired if kFlipped
  kFlipped,      ///< facets turned over to agree with their neighbours
  kInsideOut,    ///< closed shells whose normals pointed inwards: turned over
  kWelded,       ///< corners moved onto one next to them: a crack closed
  kSplit,        ///< facets cut up at a neighbour's corner on their edge: a T-junction closed
  kFlap,         ///< facets hung on an edge that had its two: dropped
  kSeparated,    ///< edges along which solids touch: each solid given corners of its own there
  kFilled,       ///< holes filled
};

struct Defect {
  DefectKind kind;
  std::uint64_t count = 0;
  std::string first;  ///< the first place: "facet 17 at (1.2, 3.4, 5.6)"
};

/// Which side of a facet is outside.
enum class Sides {
  kOutward,  ///< closed and oriented: the normal's side only
  kBoth,     ///< not to be trusted: both sides are treated as surface, which is always safe
};

/// What check_mesh() makes of a file; what it may have moved is in pathgen/mesh/mesh_check.h.
/// Properties: 1 The corners of a facet differ, and its height over its longest edge is above kMinHeight.
/// 2 Every vertex is used. 3 Sources ascend. 4 Every defect has a warning that begins with its count and
/// names its first place.
struct CheckedMesh {
  Mesh mesh;
  Sides sides = Sides::kOutward;
  std::vector<Defect> defects;        ///< in the order of DefectKind, counts > 0 only
  std::vector<std::string> warnings;  ///< one line each: count, first place, consequence
  Box bounds;
  double volume = 0.0;  ///< mm^3, of the mesh as repaired; meaningful where closed
};

std::string to_string(DefectKind kind);

}  // namespace tiltfeed::pathgen
