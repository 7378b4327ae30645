#pragma once
// Joint moves at other speeds: cut up where the speed changes.

#include <vector>

#include "daemon/plan/feed_profile.h"
#include "kinematics/joints/joint_moves.h"

namespace tiltfeed::daemon {

struct SpeedWords {
  const MachineModel& machine;
  int linear_decimals = 4, rotary_decimals = 4;  ///< of the places at which moves are cut up
  double least_seconds = 0.0;                    ///< a move is not made shorter than this, nor a piece of one
};

/// The moves with the speed of the step that they lie in; a cut within which it changes is several.
/// Properties: 1 All places of `moves` are passed, in their order. 2 No axis is faster than its velocity;
/// what the moves are slower than it for is kept in the same proportion. 3 Only cuts change. 4 With all
/// speeds 1 the moves are the same.
std::vector<JointMove> at_speeds(const std::vector<JointMove>& moves, const std::vector<SpeedStep>& steps,
                                 const SpeedWords& words);

}  // namespace tiltfeed::daemon
