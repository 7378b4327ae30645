#pragma once
// A part for the z-map: a block whose top is a field of heights, triangulated on a square grid.

#include <cstddef>

#include "sim/parts/parts.h"

namespace tiltfeed::bench {

/// 100 mm square, waves of 3 to 60 mm on it, closed; about so many facets. Requires: facets >= 8.
sim::Triangles height_field(std::size_t facets);

}  // namespace tiltfeed::bench
