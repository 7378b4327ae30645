#pragma once
// What of a verification's figures is a failure, in words.

#include "sim/path_check/path_check_report.h"

namespace tiltfeed::sim {

/// Adds to report.failures one line (value, limit, place) for each figure beyond its limit.
void judge(PathCheckReport& report);

}  // namespace tiltfeed::sim
