#pragma once
// Rows that go all the way round and end where they begin: they may begin anywhere. (L9) in
// pathgen/linking/README.md.

#include "pathgen/envelope/pass.h"

namespace tiltfeed::pathgen {

/// Does the row end where it begins, a turn on?
bool goes_round(const Pass& row);

/// The closed row, in the sense asked for, from that of its points on which comes next behind the place of
/// the row that is nearest to `from`. Properties: 1 It has every point of the row once, and that one at both
/// ends. 2 Its flat places run on over the seam. Requires: goes_round(row).
Pass begun_near(const Pass& row, bool reversed, Point<Part> from);

}  // namespace tiltfeed::pathgen
