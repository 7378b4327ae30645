#pragma once
// Roughing in layers of constant z': raster passes from the stock's top down to the part. (Z5) in
// pathgen/pattern/README.md.

#include <vector>

#include "pathgen/envelope/heights.h"
#include "pathgen/pattern/contours.h"

namespace tiltfeed::pathgen {

struct RoughLayer {
  double upper = 0.0, lower = 0.0;  ///< z' of the floor above and of this one, mm
  double tolerance = 0.0;           ///< of straight moves on the floor, mm
  double max_axis_step = 0.0;       ///< rad
  bool over_gaps = false;           ///< the floor goes on along the whole line where there is no surface
};

/// The passes of one line at z' = max(envelope, lower), without what is higher than `upper`: that is at the
/// part already. `passes`: Envelope::along(line). Ends and the places where a pass comes down to the floor
/// are found within kTrimStep; none is higher than it may be.
std::vector<Pass> layer_passes(const std::vector<Pass>& passes, const FlatLine& line, const RoughLayer& layer,
                               Heights& heights);

/// All layers over all lines, one group for each line of each layer: from `stock_top` (z' of the CL
/// reference) down to the lowest place of the lines, or to height.low, evenly and at most step_down apart.
/// Errors: kLimit, kInput for the step; kUnreachable when nothing lies below stock_top; kCancelled.
Result<Contours> rough_layers(const ClField& field, const std::vector<FlatLine>& lines, double stock_top,
                              bool over_gaps, const ContourOptions& options, const Progress& progress);

}  // namespace tiltfeed::pathgen
