#pragma once
// One operation of a job on its way: path, joints and times, before anything is text.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/job.h"
#include "daemon/plan/stage_clock.h"
#include "daemon/plan/start_turn.h"
#include "daemon/post/block.h"
#include "kinematics/basics/result.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/joints/singularity_bend.h"
#include "kinematics/timing/lower_bounds.h"
#include "kinematics/timing/timing.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/part_file/part_model.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed::daemon {

class OperationPlan {
 public:
  /// `clock` and `told` outlive it.
  OperationPlan(config::Job job, StageClock& clock, const PlanListener& told);

  /// The tool path. `rest`: what it leaves uncut is looked for, too. Errors: those of pathgen::plan, of a
  /// fixture's file; kCancelled.
  Result<void> plan_path(std::shared_ptr<const pathgen::CheckedMesh> part, const pathgen::PartModel& model,
                         bool rest);
  /// Joints, where TCP begins, times; once, and again after turn_tilt_over(). Errors: as to_joints;
  /// kCancelled.
  Result<void> find_joints();
  /// The program's part that this operation is. It points into this object.
  PlannedProgram posted(const HeaderFacts& header) const;

  /// On which side of home the tilt leans most, -1 or 1; 0: it stands at home.
  int tilt_side() const;
  /// The joints are to be found with the tilt on the other side than the one where it leans most.
  void turn_tilt_over() { job_.machine.model.preferred_tilt = -tilt_side(), joints_known_ = false; }

  const config::Job& job() const { return job_; }
  const pathgen::CheckedMesh& part() const { return *part_; }
  const pathgen::PlanReport& plan_report() const { return planned_.report; }
  void warn(const std::string& text) { planned_.report.warnings.push_back(text); }
  const SingularityBendReport& bend() const { return *bend_; }
  const JointPath& joints() const { return joints_; }
  const std::optional<StartTurn>& turn() const { return turn_; }
  const Timing& timing() const { return timing_; }
  LowerBounds bounds() const { return lower_bounds(planned_.path, joints_.moves, job_.machine.model); }
  /// As the CL file has it, for any machine.
  const ToolPath& cl_path() const { return planned_.path; }
  /// What the blocks' moves count.
  const ToolPath& block_path() const { return runs_.empty() ? planned_.path : printed_; }

 private:
  void take_end_ways();
  void put_end_ways(const pathgen::Mesh& held);
  Result<JointPath> joints_of(ToolPath& path, const JointPathOptions& options);
  Result<void> find_path_joints(const pathgen::Mesh& held, const JointPathOptions& options);
  Result<void> find_plane_joints(const std::vector<AxisRun>& ways, const pathgen::Mesh& held,
                                 const JointPathOptions& options);
  void time_joints(const JointPathOptions& options);

  config::Job job_;
  StageClock& clock_;
  const PlanListener& told_;
  std::shared_ptr<const pathgen::CheckedMesh> part_;
  std::optional<pathgen::Mesh> held_;  ///< part and fixtures, where there are any
  pathgen::Plan planned_;
  struct EndWays {
    bool before = false, behind = false;
    double length = 0.0;  ///< mm
  };
  EndWays ends_;  ///< of planned_.path, in it
  std::optional<SingularityBendReport> bend_;
  JointPath joints_;
  bool joints_known_ = false;
  std::vector<AxisRun> runs_;  ///< of joints_, each in a tilted plane; empty: the program is in none
  ToolPath printed_;           ///< with runs_
  std::optional<StartTurn> turn_;
  Timing timing_;
};

}  // namespace tiltfeed::daemon
