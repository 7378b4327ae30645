#pragma once
// From the pattern that a job asks for to its passes, in the order in which they are cut.

#include "kinematics/basics/result.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

/// The passes of the pattern on this field; groups where the pattern has groups.
/// Properties: 1 A contour of z_level has one height, and heights are at most step_down apart: within
/// 2e-6 mm. 2 No level is nearer to the point, line or circle than kLeastAxisDistance. 3 A split cuts by
/// contours where the surface is steeper than split_slope, by rows elsewhere, and both overlap by the side
/// step. 4 No move of raster or z_level is longer than envelope.max_distance or turns the axis by more than
/// envelope.max_axis_step.
/// Errors: as trace_raster, z_level, region_pattern and rough_layers.
Result<Passes> trace_pattern(const ClField& field, const PlanOptions& options,
                             const EnvelopeOptions& envelope, double thinning, const Progress& progress,
                             std::vector<std::string>& warnings);

}  // namespace tiltfeed::pathgen
