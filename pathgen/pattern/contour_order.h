#pragma once
// The order in which the contours of all levels are cut. (Z4) in pathgen/pattern/README.md.

#include <vector>

#include "pathgen/pattern/level_set.h"

namespace tiltfeed::pathgen {

struct LoopId {
  int level = 0, loop = 0;
};

/// Every loop once, in groups that are cut one after the other. `sets`: from the highest level down, at least
/// one loop or none each.
/// Properties: a loop comes after every loop of a higher level that bounds the same pocket above it, or the
/// same island on open ground; what is started is followed down as far as that allows.
std::vector<std::vector<LoopId>> order_of(const std::vector<LevelSet>& sets);

}  // namespace tiltfeed::pathgen
