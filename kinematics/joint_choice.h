#pragma once
// Which of the many joint positions of a pose: head branch, turns of the table, the pole, limits; rounded to
// the printed decimals (K9).

#include <optional>
#include <string>
#include <vector>

#include "kinematics/chain.h"
#include "kinematics/machine.h"
#include "kinematics/result.h"

namespace tiltfeed {

/// The joints taken for a pose.
struct Choice {
  Joints joints;         ///< rounded
  int branch = 0;        ///< 0: physical head angle >= 0
  bool at_pole = false;  ///< inside the pole cone: the table word is the one before
  bool forced = false;   ///< a limit excluded the solution nearest to the joints before
};

class JointChooser {
 public:
  /// `pole_cone`: half-angle about the table's axis, rad, inside which the table is held.
  JointChooser(const MachineModel& machine, const Setup& setup, int linear_decimals, int rotary_decimals,
               double pole_cone);

  /// Solutions within limits to start from: smallest |C| first, positive tilt first among equals.
  /// Errors: kUnreachable, kLimit (no solution within limits).
  Result<std::vector<Choice>> starts(const Pose& pose) const;
  /// The solution within limits nearest to `from` in rotary time, max_i |dq_i| / V_i; ties keep the branch.
  /// Errors: kUnreachable, kLimit.
  Result<Choice> next(const Pose& pose, const Choice& from) const;
  /// What limit the nearest solution of all breaks, if it does.
  std::optional<std::string> nearest_breaks(const Pose& pose, const Choice& from) const;
  /// The table held or turned to `c` at a pose inside the pole cone; the head at its best.
  /// Errors: kLimit.
  Result<Choice> at_pole(const Pose& pose, const Choice& from, double c) const;
  /// The linear words for a tip and given rotary words, all rounded.
  Joints rounded(Point<Part> tip, double a, double c) const;

  const Chain& chain() const { return chain_; }

 private:
  Choice candidate(const Pose& pose, const RotaryAngles& angles, int branch, const Choice& from) const;
  std::vector<Choice> start_turns(const Pose& pose, const Choice& first) const;
  double cost(const Choice& choice, const Choice& from) const;
  Result<Choice> next_within_limits(const Pose& pose, const std::array<Choice, 2>& nearest,
                                    const Choice& from) const;
  Result<std::array<RotaryAngles, 2>> solve(const Pose& pose, double c_at_pole) const;
  bool in_cone(const Pose& pose) const;

  const MachineModel& machine_;
  Chain chain_;
  int linear_decimals_, rotary_decimals_;
  double pole_cone_;
};

}  // namespace tiltfeed
