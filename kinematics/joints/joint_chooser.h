#pragma once
// Which of the many joint positions of a pose: branch of the tilt, turns of the rotary, the pole, limits;
// rounded to the printed decimals (K9).

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/machine/chain.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// The joints taken for a pose.
struct JointSolution : Posture {  ///< rounded
  int branch = 0;                 ///< index of AxisSolutions::angles
  bool at_pole = false;           ///< inside the pole cone: the rotary word is the one before
  bool forced = false;            ///< a limit excluded the solution nearest to the joints before
};

/// What the path asks between two passages of the pole, where the rotary can be turned freely.
struct WayFromPole {
  int barred = -1;  ///< the branch not to be taken; -1: none
  struct Turns {
    double min = -kNoLimit, max = kNoLimit;  ///< of the rotary along the way, degrees, on any turn
  };
  std::array<Turns, 2> rotary;  ///< by branch; infinite: nothing is asked
  bool asks() const { return barred >= 0 || std::isfinite(rotary[0].min) || std::isfinite(rotary[1].min); }

 private:
  static constexpr double kNoLimit = std::numeric_limits<double>::infinity();
};

/// What a pose asks of the rotaries, whatever the joints before it.
struct RotarySolutions {
  struct Words {
    double tilt = 0.0, rotary = 0.0;  ///< degrees, on any turn
  };
  std::array<Words, 2> words;  ///< by branch
  bool reachable = true;
  bool in_cone = false;      ///< inside the pole cone: the rotary is held
  bool rotary_free = false;  ///< at the pole: the rotary word before is kept
  WayFromPole ahead;         ///< looked at where the path leaves the pole
};

class JointChooser {
 public:
  /// `pole_cone`: half-angle about the rotary's axis, rad, inside which the rotary is held; and what an axis
  /// may lie beyond the reach.
  JointChooser(const MachineModel& machine, const Setup& setup, int linear_decimals, int rotary_decimals,
               double pole_cone);

  /// Solutions within limits to start from: smallest |C| first, positive tilt first among equals.
  /// At the pole, where the rotary is free, first those from which the path leaves it without turning the
  /// rotary: towards `leave`, the solutions with which the path leaves the pole cone.
  /// Errors: kUnreachable, kLimit (no solution within limits).
  Result<std::vector<JointSolution>> starts(const Pose& pose, const RotarySolutions* leave = nullptr) const;
  /// The rotary word of the solution that `next` prefers from there.
  double rotary_towards(const RotarySolutions& solutions, const JointSolution& from) const {
    return candidate(solutions, preferred(solutions, from), from.joints).c;
  }
  RotarySolutions solve(const Pose& pose) const;
  /// Those with which the move from a pose in the pole cone to one beyond it leaves the cone: where the tilt
  /// does not turn the tool along a meridian (a nutating head) these are not those of its end.
  RotarySolutions leaving(const Pose& from, const Pose& to) const;
  /// The solutions within limits between which a reconfiguration can choose, on both branches: on the turns
  /// next to `from`, next to 0 and next to either limit. `solutions`: those of `pose`.
  std::vector<JointSolution> choices(const Pose& pose, const RotarySolutions& solutions,
                                     const JointSolution& from) const;
  /// The solution within limits nearest to `from` in rotary time, max_i |dq_i| / V_i; ties keep the branch.
  /// `solutions`: those of `pose`. Errors: kUnreachable, kLimit.
  Result<JointSolution> next(const Pose& pose, const RotarySolutions& solutions,
                             const JointSolution& from) const;
  /// As `next`, X Y Z left out and their limits not looked at; the next choice does not depend on them.
  Result<JointSolution> next_rotary(const Pose& pose, const RotarySolutions& solutions,
                                    const JointSolution& from) const;
  /// What limit the nearest solution of all breaks, if it does.
  std::optional<std::string> nearest_breaks(const Pose& pose, const JointSolution& from) const;
  /// The rotary held or turned to `c` at a pose inside the pole cone; the tilt at its best.
  /// Errors: kLimit.
  Result<JointSolution> at_pole(const Pose& pose, const JointSolution& from, double c) const;
  /// The rounded linear words for a tip and rounded rotary words.
  Posture placed(Point<Part> tip, double a, double c) const;

  const Chain& chain() const { return chain_; }
  const Setup& setup() const { return setup_; }

 private:
  struct Candidate {
    double a = 0.0, c = 0.0;  ///< words, rounded
    int branch = 0;
  };
  /// On the turns nearest to `from`.
  RotarySolutions::Words nearest(const RotarySolutions& solutions, int branch, const Joints& from) const;
  Candidate candidate(const RotarySolutions& solutions, int branch, const Joints& from) const;
  std::array<Candidate, 2> candidates(const RotarySolutions& solutions, const Joints& from) const;
  /// The branch that `next` prefers: by rounded words, looked at only where rounding might decide.
  int preferred(const RotarySolutions& solutions, const JointSolution& from) const;
  double cost(double a, double c, const Joints& from) const;
  JointSolution placed(Point<Part> tip, const Candidate& candidate) const;
  Posture rounded(Point<Part> tip, double a, double c) const;
  std::vector<JointSolution> start_turns(const Pose& pose, const JointSolution& first) const;
  /// On any turn within the limits, the nearest to `from`. `ahead`: what is asked besides; null: nothing.
  std::optional<JointSolution> next_within_limits(const Pose& pose, const std::array<Candidate, 2>& nearest,
                                                  const JointSolution& from, const WayFromPole* ahead) const;
  /// Where the rotary turns to from there.
  WayFromPole::Turns turns_from(const WayFromPole& ahead, int branch, double c) const;
  /// The limit that is broken there or, by the rotary, further on.
  std::optional<std::string> breaks_ahead(const WayFromPole& ahead, const JointSolution& from) const;
  /// From there the rotary stays within its limits up to the pole.
  bool leads(const WayFromPole& ahead, int branch, double c) const;
  tl::unexpected<Error> unreachable(const Pose& pose) const;

  const MachineModel& machine_;
  Setup setup_;
  Chain chain_;
  int linear_decimals_, rotary_decimals_;
  double pole_cone_, cone_sine_;
  double rounding_time_;  ///< what rounding may change of the difference of two costs, min
};

}  // namespace tiltfeed
