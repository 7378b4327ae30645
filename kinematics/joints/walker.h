#pragma once
// Walks a stretch of a tool path: move by move from given joints, each cut until its blocks stay on it.
// (K6), (K8), (K10).

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "kinematics/joints/joint_choice.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/sweep.h"

namespace tiltfeed {

/// Why a walk ended early.
struct WalkStop {
  Error error;
  std::size_t move = 0;   ///< that cannot be done
  bool wound_up = false;  ///< by the table's limit, which another turn of the table may avoid
};

/// What one walk made.
struct Stretch {
  std::vector<JointMove> moves;
  JointPathReport report;  ///< of these moves and the joints before; seconds are left to the caller
  Choice end;              ///< the joints after the last move
  std::optional<WalkStop> stop;
};

class Walker {
 public:
  Walker(const ToolPath& path, const MachineModel& machine, const JointChooser& chooser,
         const JointPathOptions& options)
      : path_(path), machine_(machine), chooser_(chooser), options_(options) {}

  /// Moves `first`, `first` + 1, ... of the path, one for each of their `solutions`, from `start`.
  Stretch walk(const Choice& start, std::size_t first, std::span<const RotarySolutions> solutions);

 private:
  Result<void> advance(const Sweep& sweep, double f0, double f1, int halvings);
  using Turned = std::vector<std::pair<Choice, Deviation>>;
  Result<std::optional<Turned>> turned_in_place(const Pose& pose, double turn);
  void turn_ahead();
  Result<bool> swing(const Sweep& sweep, double f0, double f1, const Choice& goal);
  Result<void> stuck(const Sweep& sweep, double f1, const Choice& goal) const;
  Deviation check(const Sweep& sweep, double f0, double f1, const Joints& to) const;
  double excess(const Deviation& deviation, const Joints& from, const Joints& to) const;
  void quieten(const Sweep& sweep, double f0, double f1, Choice& to, Deviation& deviation,
               double& time) const;
  void emit(const Choice& to, const Deviation& deviation, double time);
  double seconds(const Joints& from, const Joints& to, double way) const;
  void note(const Joints& joints, const Deviation& deviation);

  const ToolPath& path_;
  const MachineModel& machine_;
  const JointChooser& chooser_;
  const JointPathOptions& options_;
  Stretch out_;
  Choice at_;
  std::size_t index_ = 0;  ///< of the move under way
  MoveKind kind_ = MoveKind::kRapid;
  const RotarySolutions* ends_ = nullptr;  ///< of its end
};

}  // namespace tiltfeed
