#pragma once
// A path's joints or words as the program's words say them.

#include "config/program_format.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/timing/tcp_path.h"

namespace tiltfeed::daemon {

/// Decimals of a mm to round joints to that are yet to become words of another kind: the tip's, or inches;
/// the words' own else.
inline int joint_decimals(const config::ProgramFormat& format) {
  const bool becomes = format.tcp || format.tilted_planes || format.inches;
  return becomes ? kTcpDecimals : format.linear_decimals;
}

/// X Y Z at the places that printed words say, mm. A block that changes no word is left out, and its time
/// goes to the next. Property: each place is within half of the last decimal.
JointPath printed_path(JointPath path, const config::ProgramFormat& format);

}  // namespace tiltfeed::daemon
