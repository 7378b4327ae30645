#pragma once
// Contour-parallel and spiral passes: curves of the flat plane laid on the envelope. (Z6), (Z7) in
// pathgen/pattern/README.md.

#include "pathgen/pattern/contours.h"
#include "pathgen/pattern/region_curves.h"

namespace tiltfeed::pathgen {

/// The curve at the height of the envelope, from end to end; broken where there is no surface. A closed curve
/// without a break gives a closed pass.
std::vector<Pass> lay_curve(const FlatCurve& curve, Heights& heights);

/// Where the envelope has a height: its border is found on grid lines `spacing` apart and straight between
/// them. Errors: as make_level_grid; kInput where the surface goes all round the axis, so that the flat plane
/// has no such border.
Result<std::vector<FlatRegion>> silhouette(const ClField& field, double spacing,
                                           const EnvelopeOptions& options, const Progress& progress);

/// pattern.kind kContour or kSpiral over options.boundary, or over the silhouette without one; the order and
/// the bounds are those of region_curves. Errors: as silhouette and region_curves; kUnreachable when nothing
/// is left of the region, or it has no surface.
Result<Contours> region_pattern(const ClField& field, const ContourOptions& options,
                                const Progress& progress);

}  // namespace tiltfeed::pathgen
