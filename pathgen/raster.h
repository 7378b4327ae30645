#pragma once
// The raster pattern: straight lines side by side over the whole CL surface.

#include <vector>

#include "kinematics/result.h"
#include "pathgen/flat_index.h"
#include "pathgen/plan_options.h"

namespace tiltfeed {

inline constexpr double kMaxLines = 1e6;
/// Patches met by all lines together; a path of so many points takes some 10 GB.
inline constexpr double kMaxCrossings = 100e6;

/// Lines in the direction of the pattern, evenly and at most its side step apart, the outermost half a step
/// inside the borders of the surface; line k lies to the left of line k - 1.
/// Errors: kLimit when the side step asks for more than kMaxLines or kMaxCrossings.
Result<std::vector<FlatLine>> raster_lines(const FlatIndex& index, const Pattern& pattern);

}  // namespace tiltfeed
