#include "daemon/plan/operation_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/blank_of_job.h"
#include "config/fixture_meshes.h"
#include "config/part_faces.h"
#include "daemon/plan/moves_at_speeds.h"
#include "daemon/plan/operations_before.h"
#include "daemon/post/calm_rotaries.h"
#include "daemon/post/end_ways.h"
#include "daemon/post/near_singularity.h"
#include "daemon/post/part_extent.h"
#include "daemon/post/post.h"
#include "daemon/post/printed_path.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/timing/tcp_path.h"
#include "pathgen/tool/blank_solid.h"

namespace tiltfeed::daemon {
namespace {

/// Also gives the program's words the decimals that the tolerance needs.
JointPathOptions joint_options(config::Job& job, const pathgen::Mesh& part) {
  const ToleranceBudget budget(job.plan.tolerance);
  JointPathOptions options;
  const bool leans = job.axis_tolerance.radians() > 0.0 || job.calm.radians() > 0.0;
  options.tolerance = leans ? budget.joints_beside_pole() : budget.joints();
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

/// The path from each of `begins` to the next.
std::vector<AxisRun> stretches(const ToolPath& path, const std::vector<std::size_t>& begins) {
  std::vector<AxisRun> runs;
  for (const std::size_t begin : begins) runs.push_back({runs.empty() ? 0 : runs.back().last, begin});
  runs.push_back({begins.back(), path.moves.size()});
  return runs;
}

}  // namespace

OperationPlan::OperationPlan(config::Job job, StageClock& clock, const PlanListener& told)
    : job_(std::move(job)), clock_(clock), told_(told) {}

void OperationPlan::follow(std::vector<std::shared_ptr<const pathgen::EarlierCut>> cuts) {
  if (knows_others(job_)) job_.plan.earlier = std::move(cuts);
}

std::shared_ptr<const pathgen::EarlierCut> OperationPlan::as_earlier_cut() const {
  auto cut = std::make_shared<pathgen::EarlierCut>(pathgen::EarlierCut{job_.plan, planned_.path.moves});
  cut->options.earlier.clear();
  return cut;
}

Result<void> OperationPlan::plan_path(std::shared_ptr<const pathgen::CheckedMesh> part,
                                      const pathgen::PartModel& model, bool rest) {
  part_ = std::move(part);
  job_.plan.find_rest_material = rest;
  auto fixtures = config::fixture_meshes(job_);
  if (!fixtures) return tl::unexpected(fixtures.error());
  job_.plan.fixtures = std::move(*fixtures), job_.plan.fixture_room = config::fixture_room(job_);
  if (auto kept = config::add_avoided_faces(job_, model, *part_); !kept) return kept;
  if (auto chosen = config::add_chosen_faces(job_, model, *part_); !chosen) return chosen;
  if (auto known = config::add_blank(job_, *part_); !known) return known;
  if (job_.plan.fixtures) held_ = pathgen::joined(part_->mesh, job_.plan.fixtures->mesh);
  if (job_.plan.blank) held_ = pathgen::joined(held_ ? *held_ : part_->mesh, job_.plan.blank->mesh());
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
  if (ends_.before) {
    moves.erase(moves.begin());
    moves.front().kind = MoveKind::kRapid;  // it may have become a plunge
    for (FeedChange& change : planned_.path.feeds) change.move -= change.move > 0 ? 1 : 0;
  }
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

std::unique_ptr<OperationPlan> OperationPlan::to_be_calmed(Angle cone) const {
  if (joints_.report.reconfigurations > 0 || in_stretches()) return nullptr;
  auto plan = std::make_unique<OperationPlan>(job_, clock_, told_);
  plan->job_.calm = cone;
  plan->part_ = part_, plan->held_ = held_, plan->from_ = from_;
  plan->planned_ = {*base_, planned_.report};
  plan->planned_.report.rapid_length -= ends_.length + longer_;
  return plan;
}

Result<void> OperationPlan::find_joints() {
  if (joints_known_) return {};
  take_end_ways();
  take_links();
  if (!calm_) {
    const auto shown = [&](double f) { return told_.show("calm", f); };
    const auto calm = clock_.time("calm", [&] { return calm_rotaries(job_, *part_, planned_.path, shown); });
    if (!calm) return tl::unexpected<Error>(calm.error());
    calm_ = *calm;
  }
  if (!bend_) bend_ = clock_.time("pole", [&] { return bend_near_singularity(job_, *part_, planned_.path); });
  put_links();
  const pathgen::Mesh& held = held_ ? *held_ : part_->mesh;
  const bool asked = job_.machine.format.tilted_planes;
  const ToolPath& whole = begins_.empty() ? planned_.path : stretched_;
  auto ways = asked ? axis_runs(whole, begins_) : std::nullopt;
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
  if (!ways && !begins_.empty()) ways = stretches(whole, begins_);
  if (job_.program.arc_tolerance > 0.0 && job_.machine.format.tcp)
    told_.say("no arcs: the program is under TCP, where X Y Z are the tip's");
  const JointPathOptions options = joint_options(job_, held);
  const auto found = clock_.time("joints", [&] {
    return ways ? find_run_joints(whole, *ways, held, options) : find_path_joints(held, options);
  });
  if (!found) return found;
  turn_ = start_turn(held, job_, joints_.moves.front().joints);
  own_moves_.clear();
  options_ = options;
  time_joints(options);
  joints_known_ = true;
  return {};
}

Result<JointPath> OperationPlan::joints_of(const ToolPath& path, const JointPathOptions& options,
                                           const MachineModel& machine) {
  if (!told_.show("joints", 0.0)) return fail(Code::kCancelled, "cancelled; nothing was written");
  return to_joints(path, machine, job_.setup, options, [&](double f) { return told_.show("joints", f); });
}

Result<void> OperationPlan::find_path_joints(const pathgen::Mesh& held, const JointPathOptions& options) {
  runs_.clear();
  stretches_.clear();
  put_end_ways(held);
  auto joints = joints_behind(from_, planned_.path, options, first_swing(), usual_start_);
  if (!joints) return note_limit(joints.error(), planned_.path), tl::unexpected(joints.error());
  joints_ = std::move(*joints);
  return {};
}

/// A stretch whose rotaries are come to from there, at the retract. `path`: with its reconfigurations then.
/// `usual`: where it begins as planned.
Result<JointPath> OperationPlan::joints_behind(const std::optional<Joints>& from, ToolPath& path,
                                               const JointPathOptions& options, const SwingChoice& choice,
                                               Joints& usual) {
  MachineModel machine = job_.machine.model;
  auto found = joints_of(path, options, machine);
  if (!found) return found;
  usual = found->moves.front().joints;
  if (choice.other_side) {
    machine.preferred_tilt = usual.a > machine.tilt.zero ? -1 : 1;
    found = joints_of(path, options, machine);
    if (!found) return found;
  }
  if (found->reconfigured) path = std::move(*found->reconfigured);
  const auto turns =
      choice.other_way && from ? turn_round(machine, *from, found->moves.front().joints) : std::nullopt;
  if (!turns) return found;
  Joints least = found->report.min, most = found->report.max;
  least.c += *turns, most.c += *turns;
  if (broken_limit(machine, least) || broken_limit(machine, most)) return found;
  found->report.min = least, found->report.max = most;
  for (JointMove& move : found->moves)
    move.joints.c = round_decimal(move.joints.c + *turns, options.rotary_decimals);
  return found;
}

/// Each stretch by itself, with ways along the tool at its ends; between them the retract.
Result<void> OperationPlan::find_run_joints(const ToolPath& whole, const std::vector<AxisRun>& ways,
                                            const pathgen::Mesh& held, const JointPathOptions& stated) {
  JointPathOptions options = stated;
  if (job_.machine.format.tilted_planes) options.clear = {};  // no rotary turns within a run
  RunJoints joints(job_.machine.model);
  stretches_.clear();
  printed_ = {
      planned_.path.name, planned_.path.tool, planned_.path.cut_feed, planned_.path.plunge_feed, {}, {}};
  std::size_t link = 0;
  for (const AxisRun& run : ways) {
    ToolPath part = part_of(whole, run);
    add_end_ways(part, held, job_);
    const bool begins = stretches_.empty();
    const SwingChoice& choice = begins ? first_swing() : kSwingChoices[swings_[link]];
    stretches_.push_back({link, {}});
    Joints& usual = begins ? usual_start_ : stretches_.back().usual;
    const auto from = begins ? from_ : std::optional(joints.path.moves.back().joints);
    auto found = joints_behind(from, part, options, choice, usual);
    if (!found) return note_limit(found.error(), part, link), tl::unexpected(found.error());
    joints.add(*found, printed_.moves.size(), choice.way);
    printed_.moves.insert(printed_.moves.end(), part.moves.begin(), part.moves.end());
    link += link_ways(part).size() - 1;
  }
  joints_ = std::move(joints.path);
  runs_ = std::move(joints.runs);
  // The CL file has the path as one, for other machines.
  put_end_ways(held);
  return {};
}

void OperationPlan::run_at(const std::vector<SpeedStep>& steps, double least_seconds) {
  if (own_moves_.empty()) own_moves_ = joints_.moves;
  joints_.moves =
      at_speeds(own_moves_, steps,
                {job_.machine.model, options_.linear_decimals, options_.rotary_decimals, least_seconds});
  joints_.report.seconds = 0.0;
  for (const JointMove& move : joints_.moves) joints_.report.seconds += move.seconds;
  time_joints(options_);
}

void OperationPlan::time_joints(const JointPathOptions& options) {
  timing_ = clock_.time("timing", [&] {
    std::vector<JointMove> started = start_moves(job_.machine, job_.setup, joints_.moves);
    const std::size_t before = started.empty() ? 0 : started.size() - 1;
    if (before > 0) started.insert(started.end(), joints_.moves.begin() + 1, joints_.moves.end());
    Timing timing = time_moves(before > 0 ? started : joints_.moves, job_.machine, options.tolerance,
                               options.axis_tolerance);
    // Of the blocks of the path alone.
    timing.durations.erase(timing.durations.begin(),
                           timing.durations.begin() + static_cast<std::ptrdiff_t>(before));
    return timing;
  });
}

PlannedProgram OperationPlan::posted(const HeaderFacts& header) const {
  PlannedProgram program = planned_program(joints_, runs_, job_, header);
  if (from_) program.posting.operations.front().way = first_swing().way;
  return program;
}

}  // namespace tiltfeed::daemon
