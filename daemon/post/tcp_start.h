#pragma once
// How TCP begins on a control that may count X Y Z from the table as it stands there.

#include <vector>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"
#include "kinematics/joints/joint_moves.h"

namespace tiltfeed::daemon {

/// The rotaries of the table turn so far in a block of the start at most, both together, degrees. Between its
/// ends the slides leave their place by 4 % of the tip's distance from the axes.
inline constexpr double kStartStep = 30.0;

/// Where the control puts the axes for these words under TCP.
Joints axes_under_tcp(const MachineModel& machine, const Setup& setup, const Joints& words);

/// Where the axes stand at the first block of an operation, whose words these are. Under TCP X and Y are
/// rounded as they are printed before TCP begins, not over an end of their travel.
Joints first_place(const config::MachineProfile& machine, const Setup& setup, const Joints& words);

/// Where the axes stand for these words of the tip in the part's frame, X and Y rounded as they are printed,
/// not over an end of their travel.
Joints place_above(const config::MachineProfile& machine, const Setup& setup, const Joints& tip_words);

/// The words under TCP before an operation's first block, `first` its slides and rotaries. TCP begins at the
/// first of them, the table at home; then the table turns to its place. At the end of each block the slides
/// are where they were: X and Y those of `first`, Z the machine's tcp_start_below under the end of its
/// travel, or that of `first` where that is higher. Words are rounded, and no slide is over an end of its
/// travel by that. Empty: the control begins anywhere, or the table is at home. Requires: tcp_can_begin().
std::vector<Joints> tcp_start(const config::MachineProfile& machine, const Setup& setup, const Joints& first);

/// The same as moves of the axes in front of an operation's, `moves`, whose first they end with: at axis
/// speed from where TCP begins. Empty: no such words.
std::vector<JointMove> start_moves(const config::MachineProfile& machine, const Setup& setup,
                                   const std::vector<JointMove>& moves);

/// Before an operation is planned. Errors: kInput, with the profile's name: a rotary of the table cannot
/// stand at home; without a retract the table would turn under the tool between the operations.
Result<void> tcp_can_begin(const config::MachineProfile& machine, std::size_t operations);

}  // namespace tiltfeed::daemon
