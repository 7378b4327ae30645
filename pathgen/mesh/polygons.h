#pragma once
// Corners and the polygons between them, as OBJ and PLY files have them, and the facets that they make; used
// by the readers of those files only.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::pathgen {

/// Polygon i has the corners corner_of[first[i]] up to corner_of[first[i + 1]].
struct Polygons {
  std::vector<Point<Part>> corners;  ///< in the file's unit
  std::vector<std::uint32_t> corner_of;
  std::vector<std::uint64_t> first = {0};
  std::vector<std::uint64_t> place;  ///< of each polygon: its line, or its number
  const char* place_name = "line";   ///< what `place` counts
  std::vector<std::string> warnings;
};

/// Triangles as they are, other polygons cut up from the corner that sees all others.
/// Properties: the corners of a facet are corners of its polygon, in its order. Errors: kInput: a corner that
/// is not there, with its place; kMesh: a polygon that no corner cuts up (it is not convex); kLimit over
/// kMaxFacets. Warns of polygons that are not flat, with the most that they leave their plane.
Result<Stl> facets_of(Polygons polygons, const std::string& name, double unit_mm);

}  // namespace tiltfeed::pathgen
