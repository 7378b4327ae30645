#pragma once
// Ways over the clearance surface against the blank that a job states. (U8) in pathgen/plan/README.md.

#include <functional>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/envelope/pass.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// Would what of the tool is beyond its column come within half of the approach of the blank, from one pose
/// to the next? Within the column the clearance surface is over all of the blank. Empty where columns do not
/// end: they do at the axis of Theta of a circle. Both must outlive the function.
std::function<bool(const Pose&, const Pose&)> meets_blank(const PlanOptions& options, const Deformation& map);

/// In inside work the clearance surface is in a hollow of the part. Fails where that of `rows` is in the
/// blank: the first operation finds no hollow there.
Result<void> begin_off_blank(const std::vector<std::vector<Pass>>& rows, const PlanOptions& options,
                             const Deformation& map, double clearance_z);

}  // namespace tiltfeed::pathgen
