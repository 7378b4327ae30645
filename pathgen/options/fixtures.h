#pragma once
// What holds the part on the table: surfaces that are never cut and that the tool keeps clear of. They turn
// with the part, so that they stand still in part coordinates.

#include <string>
#include <vector>

#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

struct Fixtures {
  Mesh mesh;  ///< of all bodies, at least one facet, part coordinates; source[i]: the body of facet i
  std::vector<std::string> names;  ///< by body
  Sides sides = Sides::kOutward;
};

/// How far cutter, shank and holder keep off fixtures, mm: on rapids, too.
struct FixtureRoom {
  double cutter = 0.0, shank = 0.0, holder = 0.0;
};

/// One mesh; the part's facets and vertices first.
Mesh joined(const Mesh& part, const Mesh& fixtures);

}  // namespace tiltfeed::pathgen
