#pragma once
// Pencil passes: one along each crease of the CL surface, where the tool touches the part at two places. (Z8)
// in pathgen/pattern/README.md.

#include "pathgen/creases/creases.h"
#include "pathgen/pattern/contours.h"

namespace tiltfeed::pathgen {

/// Of the cutter's diameter: the distance of the lines on which creases are looked for.
inline constexpr double kPencilSpacing = 0.25;
/// Likewise, the least length of a crease that ends by itself.
inline constexpr double kPencilLength = 0.25;

/// pattern.kind kPencil over `bounds`, one group for each crease, from each to the nearest that is left.
/// `thinning`: as trace_raster. Properties: 1 Each point is on the envelope. 2 It is at most `tolerance` off
/// a crease, to the side that climbs less where the other is steep. Errors: as trace_crease_graph;
/// kUnreachable where there is no crease.
Result<Contours> pencil(const ClField& field, const FlatBounds& bounds, const ContourOptions& options,
                        double diameter, double thinning, const Progress& progress);

}  // namespace tiltfeed::pathgen
