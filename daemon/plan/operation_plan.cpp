#include "daemon/plan/operation_plan.h"

#include <algorithm>
#include <cmath>

#include "config/avoided_faces.h"
#include "config/fixture_meshes.h"
#include "daemon/post/end_ways.h"
#include "daemon/post/near_singularity.h"
#include "daemon/post/part_extent.h"
#include "daemon/post/post.h"
#include "daemon/post/printed_path.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/timing/tcp_path.h"

namespace tiltfeed::daemon {
namespace {

/// Also gives the program's words the decimals that the tolerance needs.
JointPathOptions joint_options(config::Job& job, const pathgen::Mesh& part) {
  const ToleranceBudget budget(job.plan.tolerance);
  JointPathOptions options;
  options.tolerance = job.axis_tolerance.radians() > 0.0 ? budget.joints_beside_pole() : budget.joints();
  options.reach = job.plan.cutter.shank_length;
  // What the axis may lean moves the shank's end by no more than the tip may stray; under TCP the words do so
  // once more.
  const double strays =
      job.machine.format.tcp ? std::min(options.tolerance, budget.joints_before_words()) : options.tolerance;
  const Angle lean = Angle::from_radians(strays / job.plan.cutter.shank_length);
  options.axis_tolerance = std::min(options.axis_tolerance, lean.degrees());
  job.machine.format = config::fine_enough(job.machine.format, options.tolerance, options.axis_tolerance);
  // Joints that become other words are kept finer than what is printed.
  options.linear_decimals = joint_decimals(job.machine.format);
  options.rotary_decimals = job.machine.format.rotary_decimals;
  options.clear = part_extent(part, job);
  return options;
}

}  // namespace

OperationPlan::OperationPlan(config::Job job, StageClock& clock, const PlanListener& told)
    : job_(std::move(job)), clock_(clock), told_(told) {}

Result<void> OperationPlan::plan_path(std::shared_ptr<const pathgen::CheckedMesh> part,
                                      const pathgen::PartModel& model, bool rest) {
  part_ = std::move(part);
  job_.plan.find_rest_material = rest;
  auto fixtures = config::fixture_meshes(job_);
  if (!fixtures) return tl::unexpected(fixtures.error());
  job_.plan.fixtures = std::move(*fixtures), job_.plan.fixture_room = config::fixture_room(job_);
  if (auto kept = config::add_avoided_faces(job_, model, *part_); !kept) return kept;
  if (job_.plan.fixtures) held_ = pathgen::joined(part_->mesh, job_.plan.fixtures->mesh);
  auto planned =
      pathgen::plan(*part_, job_.plan, [&](const char* stage, double f) { return told_.show(stage, f); });
  if (!planned) return tl::unexpected(planned.error());
  planned_ = std::move(*planned);
  for (const pathgen::StageTime& time : planned_.report.times) clock_.add(time);
  return {};
}

int OperationPlan::tilt_side() const {
  const RotaryAxis& tilt = job_.machine.model.tilt;
  double most = 0.0;
  for (const JointMove& move : joints_.moves)
    if (const double lean = move.joints.a - tilt.zero; std::abs(lean) > std::abs(most)) most = lean;
  return tilt.present ? (most > 0.0) - (most < 0.0) : 0;
}

/// What put_end_ways() has put in: it depends on how the rotaries stand.
void OperationPlan::take_end_ways() {
  std::vector<Move>& moves = planned_.path.moves;
  if (ends_.behind) moves.pop_back();
  if (ends_.before) moves.erase(moves.begin());
  planned_.report.rapid_length -= ends_.length;
  ends_ = {};
}

void OperationPlan::put_end_ways(const pathgen::Mesh& held) {
  const std::vector<Move>& moves = planned_.path.moves;
  const Pose first = moves.front().pose;
  const std::size_t count = moves.size();
  ends_.length = add_end_ways(planned_.path, held, job_);
  ends_.before = moves.front().pose != first;
  ends_.behind = moves.size() > count + (ends_.before ? 1 : 0);
  planned_.report.rapid_length += ends_.length;
}

Result<void> OperationPlan::find_joints() {
  if (joints_known_) return {};
  take_end_ways();
  if (!bend_) bend_ = clock_.time("pole", [&] { return bend_near_singularity(job_, *part_, planned_.path); });
  const pathgen::Mesh& held = held_ ? *held_ : part_->mesh;
  const bool asked = job_.machine.format.tilted_planes;
  const auto ways = asked ? axis_runs(planned_.path) : std::nullopt;
  if (asked && !ways)
    told_.say(
        "no tilted planes: a rotary turns in a cut, and the program is posted as if the profile did not ask "
        "for them");
  if (asked && !ways && job_.program.plane_offsets)
    return fail(Code::kInput,
                "a rotary turns in a cut, so that the program is in no tilted planes, and each plane is to "
                "have a work offset of its own; state program.plane_offsets: false");
  if (ways) job_.machine.format = config::in_tilted_planes(job_.machine.format);
  job_.machine.format.tilted_planes = ways.has_value();
  if (job_.program.arc_tolerance > 0.0 && job_.machine.format.tcp)
    told_.say("no arcs: the program is under TCP, where X Y Z are the tip's");
  const JointPathOptions options = joint_options(job_, held);
  const auto found = clock_.time("joints", [&] {
    return ways ? find_plane_joints(*ways, held, options) : find_path_joints(held, options);
  });
  if (!found) return found;
  turn_ = start_turn(held, job_, joints_.moves.front().joints);
  time_joints(options);
  joints_known_ = true;
  return {};
}

Result<JointPath> OperationPlan::joints_of(ToolPath& path, const JointPathOptions& options) {
  if (!told_.show("joints", 0.0)) return fail(Code::kCancelled, "cancelled; nothing was written");
  return to_joints(path, job_.machine.model, job_.setup, options,
                   [&](double f) { return told_.show("joints", f); });
}

Result<void> OperationPlan::find_path_joints(const pathgen::Mesh& held, const JointPathOptions& options) {
  put_end_ways(held);
  auto joints = joints_of(planned_.path, options);
  if (!joints) return tl::unexpected(joints.error());
  joints_ = std::move(*joints);
  if (joints_.reconfigured) planned_.path = std::move(*joints_.reconfigured);
  return {};
}

/// Each run of one axis by itself, with ways along the tool at its ends.
Result<void> OperationPlan::find_plane_joints(const std::vector<AxisRun>& ways, const pathgen::Mesh& held,
                                              const JointPathOptions& stated) {
  JointPathOptions options = stated;
  options.clear = {};  // no rotary turns within a run
  PlaneJoints joints(job_.machine.model);
  printed_ = {
      planned_.path.name, planned_.path.tool, planned_.path.cut_feed, planned_.path.plunge_feed, {}, {}};
  for (const AxisRun& run : ways) {
    ToolPath part = part_of(planned_.path, run);
    add_end_ways(part, held, job_);
    auto found = joints_of(part, options);
    if (!found) return tl::unexpected(found.error());
    joints.add(*found, printed_.moves.size());
    printed_.moves.insert(printed_.moves.end(), part.moves.begin(), part.moves.end());
  }
  joints_ = std::move(joints.path);
  runs_ = std::move(joints.runs);
  // The CL file has the path as one, for other machines.
  put_end_ways(held);
  return {};
}

void OperationPlan::time_joints(const JointPathOptions& options) {
  timing_ = clock_.time("timing", [&] {
    const config::ProgramFormat& format = job_.machine.format;
    std::vector<JointMove> started = start_moves(job_.machine, job_.setup, joints_.moves);
    const std::size_t before = started.empty() ? 0 : started.size() - 1;
    if (before > 0) started.insert(started.end(), joints_.moves.begin() + 1, joints_.moves.end());
    Timing timing =
        time_blocks(before > 0 ? started : joints_.moves, job_.machine.model,
                    rounded_off_by(format, options.tolerance), options.axis_tolerance, corners_of(format));
    // Of the blocks of the path alone.
    timing.durations.erase(timing.durations.begin(),
                           timing.durations.begin() + static_cast<std::ptrdiff_t>(before));
    return timing;
  });
}

PlannedProgram OperationPlan::posted(const HeaderFacts& header) const {
  return planned_program(joints_, runs_, job_, header);
}

}  // namespace tiltfeed::daemon
