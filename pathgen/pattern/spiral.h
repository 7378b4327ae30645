#pragma once
// Closed curves, one inside the other, joined to a spiral. (Z7) in pathgen/pattern/README.md.

#include <vector>

#include "pathgen/pattern/flat_offset.h"

namespace tiltfeed::pathgen {

/// One curve that runs once along the first ring, comes over evenly from ring to ring in a turn each, and
/// ends with once along the last. Where a ring has parts that are far from the next (an arm that ends) the
/// spiral ends too, and another begins. Requires: rings closed, all the same way round, from the outside
/// inwards.
std::vector<FlatCurve> spirals_through(const std::vector<FlatCurve>& rings, double side_step);

}  // namespace tiltfeed::pathgen
