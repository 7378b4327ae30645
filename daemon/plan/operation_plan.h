#pragma once
// One operation of a job on its way: path, joints and times, before anything is text.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/job.h"
#include "daemon/plan/feed_profile.h"
#include "daemon/plan/link_choice.h"
#include "daemon/plan/stage_clock.h"
#include "daemon/plan/start_turn.h"
#include "daemon/plan/swing_choice.h"
#include "daemon/post/block.h"
#include "kinematics/basics/result.h"
#include "kinematics/joints/calm_axes.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/joints/singularity_bend.h"
#include "kinematics/timing/lower_bounds.h"
#include "kinematics/timing/time_by_motion.h"
#include "kinematics/timing/timing.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/part_file/part_model.h"
#include "pathgen/plan/plan.h"
#include "pathgen/stock/stock_on_cuts.h"

namespace tiltfeed::daemon {

/// What of a program's ways has other choices.
struct LinkPlace {
  std::size_t link = 0;
  /// The axes' way at the retract, between the stretches at both ends of the link; of the first link between
  /// the operation before and this one.
  bool swing = false;

  bool operator==(const LinkPlace&) const = default;
};

class OperationPlan {
 public:
  /// `clock` and `told` outlive it.
  OperationPlan(config::Job job, StageClock& clock, const PlanListener& told);

  /// What the operations before have cut, for plan_path() of one that knows_others().
  void follow(std::vector<std::shared_ptr<const pathgen::EarlierCut>> cuts);
  /// This operation as one before others. After plan_path().
  std::shared_ptr<const pathgen::EarlierCut> as_earlier_cut() const;
  /// The tool path. `rest`: what it leaves uncut is looked for, too. Errors: those of pathgen::plan, of a
  /// fixture's file; kCancelled.
  Result<void> plan_path(std::shared_ptr<const pathgen::CheckedMesh> part, const pathgen::PartModel& model,
                         bool rest);
  /// Joints, where TCP begins, times; once, and again after turn_tilt_over(). Errors: as to_joints;
  /// kCancelled.
  Result<void> find_joints();
  /// The program's part that this operation is. It points into this object.
  PlannedProgram posted(const HeaderFacts& header) const;

  /// The same way at other speeds, where it cuts: blocks are cut up where the speed changes. `least_seconds`:
  /// of a block that is made shorter. Steps count in seconds of the joints that find_joints() found.
  /// Properties: 1 The words pass through the same places. 2 No axis is faster than it can be. 3 Without
  /// steps all is as it was. Requires: find_joints(); not in_stretches().
  void run_at(const std::vector<SpeedStep>& steps, double least_seconds);
  /// Its program is in tilted planes.
  bool in_planes() const { return in_stretches() && job_.machine.format.tilted_planes; }
  /// It is in several stretches, with a retract between each two: as in planes, or with such links.
  bool in_stretches() const { return !runs_.empty(); }

  /// On which side of home the tilt leans most, -1 or 1; 0: it stands at home.
  int tilt_side() const;
  /// The joints are to be found with the tilt on this side of home, as far as it can be.
  void prefer_tilt(int side) { job_.machine.model.preferred_tilt = side, joints_known_ = false; }
  int preferred_tilt() const { return job_.machine.model.preferred_tilt; }

  /// How each link goes, by index into kLinkChoices; empty before find_joints().
  const std::vector<std::size_t>& link_choices() const { return links_; }
  /// How the axes go from the stretch before a link to that behind it, by index into kSwingChoices.
  const std::vector<std::size_t>& swing_choices() const { return swings_; }
  /// The joints are to be found anew with these. Requires: as many as link_choices().
  void choose_links(std::vector<std::size_t> choices, std::vector<std::size_t> swings) {
    links_ = std::move(choices), swings_ = std::move(swings), joints_known_ = false;
  }
  /// Where the axes stand at the end of the operation before; nothing: there is none. They swing from there
  /// at the retract. The joints are found anew where that changes them.
  void come_from(const std::optional<Joints>& from);
  /// Moves of the path behind which the tool is taken off to turn a rotary (K11), with every link as planned.
  std::vector<std::size_t> turns_back() const;
  /// There the tool is to be taken off to the machine's retract instead, as by a link: in a cut one is put
  /// in. The joints are to be found anew. False: the program has no retract there. Requires: turns_back().
  bool turn_at_retract(const std::vector<std::size_t>& behind);
  /// The least choice of a link: of one that a rotary turns in, that of the retract.
  std::size_t least_choice(std::size_t link) const;
  /// Whether the link, or the swing, goes another way with this choice than with those before it. Of a swing
  /// between the joints that are known. Requires: joints.
  bool link_differs(std::size_t link, std::size_t choice) const;
  bool swing_differs(std::size_t link, std::size_t choice) const;
  /// The link, or its swing, in which the axes come by these words, in a rapid or not; nothing: no link's
  /// move does, as a cut does, or the way to where TCP begins. Requires: joints.
  std::optional<LinkPlace> link_at(const Joints& words, bool rapid) const;
  /// The link that comes nearest to a place of the tip.
  std::size_t link_near(Point<Part> tip) const;
  /// The link whose new way find_joints() has refused at last for a limit of an axis.
  std::optional<std::size_t> limited_link() const { return limited_; }

  const config::Job& job() const { return job_; }
  const pathgen::PlanReport& report() const { return planned_.report; }
  const pathgen::CheckedMesh& part() const { return *part_; }
  const pathgen::PlanReport& plan_report() const { return planned_.report; }
  /// What was found of what the operations before leave, where all is cut nevertheless.
  void found_before(pathgen::RestBefore before) {
    before.all_cut = true;
    planned_.report.rest = before;
  }
  /// What shank and holder meet of the stock; nothing: nobody knows that.
  const std::optional<pathgen::StockOnCuts>& stock_on_cuts() const { return stock_on_cuts_; }
  void found_stock(const pathgen::StockOnCuts& found) { stock_on_cuts_ = found; }
  void warn(const std::string& text) { planned_.report.warnings.push_back(text); }
  const SingularityBendReport& bend() const { return *bend_; }
  const CalmReport& calm() const { return *calm_; }
  /// The same passes, and what they leave before the axis leans, for find_joints() with Job::calm of `cone`.
  /// Null: it has to be planned anew, as the tool is taken off in a pass (K11) or it is in tilted planes.
  /// Requires: find_joints(), no calm axes, and links as planned.
  std::unique_ptr<OperationPlan> to_be_calmed(Angle cone) const;
  /// Its passes are those of `other`, which knows what they leave before the axis leans.
  void leaves_as(const OperationPlan& other) {
    planned_.report.uncut = other.planned_.report.uncut;
    planned_.report.between = other.planned_.report.between;
    planned_.report.warnings = other.planned_.report.warnings;
  }
  const JointPath& joints() const { return joints_; }
  const std::optional<StartTurn>& turn() const { return turn_; }
  const Timing& timing() const { return timing_; }
  LowerBounds bounds() const { return lower_bounds(planned_.path, joints_.moves, job_.machine.model); }
  TimeByMotion by_motion() const {
    return time_by_motion(block_path(), joints_.moves, timing_.durations, job_.machine.model);
  }
  /// As the CL file has it, for any machine.
  const ToolPath& cl_path() const { return planned_.path; }
  /// What the blocks' moves count.
  const ToolPath& block_path() const { return runs_.empty() ? planned_.path : printed_; }

 private:
  void take_end_ways();
  void put_end_ways(const pathgen::Mesh& held);
  void take_links();
  void put_links();
  void note_limit(const Error& error, const ToolPath& path, std::size_t first_link = 0);
  Result<JointPath> joints_of(const ToolPath& path, const JointPathOptions& options,
                              const MachineModel& machine);
  Result<JointPath> joints_behind(const std::optional<Joints>& from, ToolPath& path,
                                  const JointPathOptions& options, const SwingChoice& choice, Joints& usual);
  const SwingChoice& first_swing() const { return kSwingChoices[from_ ? swings_.front() : 0]; }
  bool retracts() const;
  Result<void> find_path_joints(const pathgen::Mesh& held, const JointPathOptions& options);
  Result<void> find_run_joints(const ToolPath& whole, const std::vector<AxisRun>& ways,
                               const pathgen::Mesh& held, const JointPathOptions& options);
  void time_joints(const JointPathOptions& options);

  config::Job job_;
  StageClock& clock_;
  const PlanListener& told_;
  std::shared_ptr<const pathgen::CheckedMesh> part_;
  std::optional<pathgen::Mesh> held_;  ///< part and fixtures, where there are any
  pathgen::Plan planned_;
  std::optional<pathgen::StockOnCuts> stock_on_cuts_;
  struct EndWays {
    bool before = false, behind = false;
    double length = 0.0;  ///< mm
  };
  EndWays ends_;  ///< of planned_.path, in it
  std::optional<CalmReport> calm_;
  std::optional<SingularityBendReport> bend_;
  std::optional<ToolPath> base_;             ///< planned_.path before with_links()
  std::vector<std::size_t> links_, swings_;  ///< of its links
  double longer_ = 0.0;                      ///< what they add to the rapids, mm
  ToolPath stretched_;                       ///< base_ with its links, some with a retract
  std::vector<std::size_t> begins_;          ///< moves of stretched_ with which stretches begin; empty: none
  std::vector<std::size_t> turned_links_;    ///< of base_, in which a rotary turns at the retract
  std::optional<Joints> from_;               ///< where the operation before ends
  Joints usual_start_;                       ///< where the joints begin as planned
  std::optional<std::size_t> limited_;
  JointPath joints_;
  bool joints_known_ = false;
  std::vector<JointMove> own_moves_;  ///< of joints_ at the job's own feeds, after run_at()
  JointPathOptions options_;          ///< of joints_
  std::vector<AxisRun> runs_;         ///< of joints_, each a stretch of the program; empty: it is one
  struct Stretch {
    std::size_t link = 0;  ///< in front of it
    Joints usual;          ///< where it begins as planned
  };
  std::vector<Stretch> stretches_;  ///< of runs_
  ToolPath printed_;                ///< with runs_
  std::optional<StartTurn> turn_;
  Timing timing_;
};

}  // namespace tiltfeed::daemon
