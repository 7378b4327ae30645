#pragma once
// Another baseline: the bare 3-axis z-map, as one would write it first, on all cores. The STL's facets are
// taken as they lie in the file, not joined; the ball is dropped exactly on each, its edges and its corners,
// at each grid point near it. No mesh, no passes, no path.

#include <string>

#include "kinematics/basics/result.h"
#include "tests/bench/height_map.h"

namespace tiltfeed::bench {
using namespace pathgen;

/// From a binary STL file in mm, the axis along z. Requires: radius, step > 0 (mm); a closed part, each edge
/// of which two facets name with the same numbers. Errors: kIo.
Result<HeightMap> z_map(const std::string& stl, double radius, double step);

}  // namespace tiltfeed::bench
