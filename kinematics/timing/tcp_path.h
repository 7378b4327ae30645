#pragma once
// Joint path to the words of a control that keeps the tool centre point (TCP): X Y Z are the tip's, in the
// part's frame as it stands at table zero, and travel linearly there; the rotary words travel linearly
// besides.

#include "kinematics/joints/joint_path.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// Decimals to round the linear joints of a path to that is to be run under TCP.
inline constexpr int kTcpDecimals = 6;

struct TcpOptions {
  int linear_decimals = 4;  ///< printed decimals of X Y Z, mm
  /// Largest angle between the axis as the control turns it and that of `path`, degrees.
  double axis_tolerance = 0.05;
  /// Largest distance of a tip that is left out from the straight line, mm; kRapidToleranceFactor times that
  /// on rapids.
  double tip_tolerance = 0.01;
};

/// The words (in the places of the joints), with blocks of one move joined where the tip needs no point
/// between and the axis stays within tolerance (K7). Properties: the first block is that of `path`; the last
/// block of each move is kept; |da|, |dc| < 180 degrees in every block of feed; a block that would change no
/// word is left out; blocks of another speed are not joined.
JointPath words_under_tcp(const JointPath& path, const MachineModel& machine, const Setup& setup,
                          const TcpOptions& options);

/// The pose that the words command: the inverse of `words_under_tcp`.
Pose pose_under_tcp(const MachineModel& machine, const Setup& setup, const Joints& words);

}  // namespace tiltfeed
