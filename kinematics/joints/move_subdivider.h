#pragma once
// Walks a stretch of a tool path: move by move from given joints, each cut until its blocks stay on it.
// (K6), (K8), (K10).

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "kinematics/joints/joint_chooser.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/sweep.h"

namespace tiltfeed {

/// Why a walk ended early.
struct SubdivisionStop {
  Error error;
  std::size_t move = 0;   ///< that cannot be done
  bool wound_up = false;  ///< by the table's limit, which another turn of the table may avoid
};

/// What one walk made.
struct SubdividedMoves {
  std::vector<JointMove> moves;
  JointPathReport report;  ///< of these moves and the joints before; seconds are left to the caller
  JointSolution end;       ///< the joints after the last move
  std::optional<SubdivisionStop> stop;
};

class MoveSubdivider {
 public:
  MoveSubdivider(const ToolPath& path, const MachineModel& machine, const JointChooser& chooser,
                 const JointPathOptions& options)
      : path_(path), machine_(machine), chooser_(chooser), options_(options) {}

  /// Moves `first`, `first` + 1, ... of the path, one for each of their `solutions`, from `start`.
  SubdividedMoves walk(const JointSolution& start, std::size_t first,
                       std::span<const RotarySolutions> solutions);

 private:
  Result<void> advance(const Sweep& sweep, double f0, double f1, int halvings);
  using Turned = std::vector<std::pair<JointSolution, Deviation>>;
  Result<std::optional<Turned>> turned_in_place(const Pose& pose, double turn);
  void turn_ahead();
  Result<bool> swing(const Sweep& sweep, double f0, double f1, const JointSolution& goal);
  Result<void> stuck(const Sweep& sweep, double f1, const JointSolution& goal) const;
  /// By what early is told from late: the tip of a ball end and its centre, or the whole axis.
  enum class Early { kTip, kAxis };
  Deviation check(const Sweep& sweep, double f0, double f1, const Joints& to, Early by = Early::kTip) const;
  double excess(const Deviation& deviation, const Joints& from, const Joints& to) const;
  void quieten(const Sweep& sweep, double f0, double f1, JointSolution& to, Deviation& deviation,
               double& time) const;
  void emit(const JointSolution& to, const Deviation& deviation, double time);
  double seconds(const Joints& from, const Joints& to, double way) const;
  void note(const Joints& joints, const Deviation& deviation);

  const ToolPath& path_;
  const MachineModel& machine_;
  const JointChooser& chooser_;
  const JointPathOptions& options_;
  SubdividedMoves out_;
  JointSolution at_;
  std::size_t index_ = 0;  ///< of the move under way
  MoveKind kind_ = MoveKind::kRapid;
  const RotarySolutions* ends_ = nullptr;  ///< of its end
};

}  // namespace tiltfeed
