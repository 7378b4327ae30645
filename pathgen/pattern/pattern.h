#pragma once
// From the pattern that a job asks for to its passes, in the order in which they are cut.

#include "kinematics/basics/result.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

/// The passes of the pattern on this field; groups where the pattern has groups. Errors: as trace_raster,
/// z_level, region_pattern and rough_layers.
Result<Passes> trace_pattern(const ClField& field, const PlanOptions& options,
                             const EnvelopeOptions& envelope, double thinning, const Progress& progress,
                             std::vector<std::string>& warnings);

}  // namespace tiltfeed::pathgen
