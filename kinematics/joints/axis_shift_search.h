#pragma once
// How far a piece of path near the pole is best bent, place by place: dynamic programming. (K13).

#include <cstddef>
#include <optional>
#include <vector>

#include "kinematics/joints/joint_chooser.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// A place of the planned path at which the bend is chosen.
struct ShiftNode {
  Pose pose;
  Vec3 ahead;                    ///< unit, square to the axis: the way that the axis goes
  double turned = 0.0;           ///< rad, of the axis since the first node
  double minutes = 0.0;          ///< at the programmed feed since the first node; rises from node to node
  double low = 0.0, high = 0.0;  ///< bends that are allowed here, rad; low <= 0 <= high
};

/// Each node has bends of so many levels to either side, square to the axis's way; the one with which a way
/// on from there meets the pole; and, where the pole is near enough, the pole itself.
inline constexpr int kBendLevels = 16;
/// The shift of the axis changes by at most this share of what the planned axis turns.
inline constexpr double kBendSlope = 0.5;
/// A full bend counts as much as a rotary at this share of its speed: a slower one is not worth it.
inline constexpr double kBendWorth = 0.1;

/// The axis of a node bent by an angle (rad) to the left of its way, seen from outside.
Vec3 bent_axis(const ShiftNode& node, double bend);

class AxisShiftSearch {
 public:
  /// `most`: rad. Words of both are those of `chooser`.
  AxisShiftSearch(const MachineModel& machine, const JointChooser& chooser, Vec3 pole, double most)
      : machine_(machine), chooser_(chooser), pole_(pole), most_(most) {}

  /// The shift of the axis by node (bent less planned unit vector), none at the first and last, that makes
  /// the least of the sum over the ways between nodes of T (share_a^2 + share_c^2 + kBendWorth^2 (shift /
  /// most)^2), T the programmed time and share what a rotary takes of its speed. Nothing where no sequence of
  /// solutions within the tilt's limits leads through.
  std::optional<std::vector<Vec3>> best(const std::vector<ShiftNode>& nodes) const;
  /// That sum for given shifts.
  std::optional<double> cost(const std::vector<ShiftNode>& nodes, const std::vector<Vec3>& shifts) const;
  /// Every shift that `best` chooses from at a node.
  std::vector<Vec3> shifts_of(const ShiftNode& node) const;

 private:
  struct State {
    Vec3 shift;
    double a = 0.0, c = 0.0;  ///< words, degrees
  };
  void add_states(const ShiftNode& node, Vec3 shift, std::vector<State>& states) const;
  double step(const State& from, const State& to, double minutes) const;
  std::optional<double> run(const std::vector<ShiftNode>& nodes,
                            const std::vector<std::vector<State>>& states, std::vector<Vec3>* shifts) const;

  const MachineModel& machine_;
  const JointChooser& chooser_;
  Vec3 pole_;
  double most_;
};

}  // namespace tiltfeed
