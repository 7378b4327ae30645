#pragma once
// What of a verification's figures is a failure, in words.

#include "sim/path_check/verify_report.h"

namespace tiltfeed::sim {

/// Adds to report.failures one line (value, limit, place) for each figure beyond its limit.
void judge(VerifyReport& report);

}  // namespace tiltfeed::sim
