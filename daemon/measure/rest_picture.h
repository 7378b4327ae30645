#pragma once
// The rest of each place as a picture: where it was measured, and how far it lies from the fit.

#include <string>
#include <vector>

#include "daemon/measure/pivot_fit.h"
#include "daemon/measure/tip_spread.h"

namespace tiltfeed::daemon {

/// An SVG. Above: places by both words, a circle as large as the rest, crosses where to measure next. Below:
/// X Y Z of each place's rest, with lines at two standard deviations.
std::string rest_picture(const PivotFit& fit, const MachineModel& machine,
                         const std::vector<std::string>& names, const std::vector<NextPlace>& next);

}  // namespace tiltfeed::daemon
