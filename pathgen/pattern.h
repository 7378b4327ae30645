#pragma once
// From the pattern that a job asks for to its passes, in the order in which they are cut.

#include "kinematics/result.h"
#include "pathgen/passes.h"
#include "pathgen/stages.h"

namespace tiltfeed {

/// The passes of the pattern on this field; groups where the pattern has groups. Errors: as trace_raster,
/// z_level, region_pattern and rough_layers.
Result<Passes> trace_pattern(const ClField& field, const PlanOptions& options,
                             const EnvelopeOptions& envelope, double thinning, const Progress& progress,
                             std::vector<std::string>& warnings);

}  // namespace tiltfeed
