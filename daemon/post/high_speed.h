#pragma once
// The words of a control's high-speed function: G5.1, G187, CYCLE832, cycle 32, G62.

#include <string>
#include <vector>

#include "daemon/post/posting.h"

namespace tiltfeed::daemon {

/// The lines that turn it on for the operation. Requires: config::has_smoothing(), and the operation states
/// it. Where rotaries turn in cuts the tip may leave the path by one half of what the control is left,
/// and the tool's other end by the other; all of it else.
std::vector<std::string> high_speed_lines(const Posting& posting, const Operation& op);

}  // namespace tiltfeed::daemon
