#include "daemon/plan/operation_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <utility>

#include "config/blank_of_job.h"
#include "config/fixture_meshes.h"
#include "config/part_faces.h"
#include "config/table_home.h"
#include "daemon/plan/moves_at_speeds.h"
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

/// Words further beside a move than this are not of it: under TCP blocks are joined. mm and degrees.
constexpr double kOffItsMove = 2.0;

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
  if (job_.plan.rest_more_than > 0.0) job_.plan.earlier = std::move(cuts);
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

Result<void> OperationPlan::find_joints() {
  if (joints_known_) return {};
  take_end_ways();
  take_links();
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

void OperationPlan::take_links() {
  if (!base_ || longer_ == 0.0) return;
  planned_.path = *base_;
  planned_.report.rapid_length -= std::exchange(longer_, 0.0);
}

void OperationPlan::put_links() {
  limited_.reset();
  begins_.clear();
  if (!base_) {
    base_ = planned_.path;
    links_.assign(link_ways(*base_).size(), 0);
    swings_ = links_;
  }
  if (std::all_of(links_.begin(), links_.end(), [](std::size_t choice) { return choice == 0; })) return;
  stretched_ = with_links(*base_, links_, &begins_);
  // The CL file has no retract: there the link is as it was planned.
  std::vector<std::size_t> of_cl = links_;
  for (std::size_t& choice : of_cl)
    if (kLinkChoices[choice].at_retract) choice = 0;
  planned_.path = with_links(*base_, of_cl);
  longer_ = rapid_length(planned_.path) - rapid_length(*base_);
  planned_.report.rapid_length += longer_;
}

bool OperationPlan::link_differs(std::size_t link, std::size_t choice) const {
  if (!differs(*base_, link, choice)) return false;
  if (!kLinkChoices[choice].at_retract) return true;
  const config::ProgramFormat& format = job_.machine.format;
  // Such a control's table would turn to its place under TCP again.
  const bool turns_home = format.tcp && config::begins_at_home(format.dialect) &&
                          !config::table_turns(job_.machine.model).empty();
  if (format.retract == "none" || turns_home) return false;
  // Between two planes there is one already.
  const LinkWay way = link_ways(*base_)[link];
  return !in_planes() || base_->moves[way.first - 1].pose.axis == base_->moves[way.last - 1].pose.axis;
}

bool OperationPlan::swing_differs(std::size_t link, std::size_t choice) const {
  for (std::size_t i = 1; i < stretches_.size(); ++i)
    if (stretches_[i].link == link)
      return differs(job_.machine.model, job_.setup, joints_.moves[runs_[i - 1].last - 1].joints,
                     stretches_[i].usual, choice);
  return false;
}

/// A limit that stands at a link's move ("move 12, ..."): the way is chosen anew, or the program refused.
/// `first_link`: that of the path's beginning.
void OperationPlan::note_limit(const Error& error, const ToolPath& path, std::size_t first_link) {
  constexpr std::string_view kMove = "move ";
  if (error.code != Code::kLimit || !error.message.starts_with(kMove)) return;
  const std::size_t move = std::strtoull(error.message.c_str() + kMove.size(), nullptr, 10);
  const std::vector<LinkWay> ways = link_ways(path);
  for (std::size_t i = 0; i < ways.size(); ++i)
    if (ways[i].has(move)) limited_ = first_link + i;
}

std::optional<LinkPlace> OperationPlan::link_at(const Joints& words, bool rapid) const {
  const std::vector<JointMove>& moves = joints_.moves;
  const std::vector<LinkWay> ways = link_ways(block_path());
  const Joints up{0, 0, job_.machine.model.z.max, 0, 0};
  // How far beside a move they are, mm and degrees; whole turns are none.
  const auto off = [&](const Joints& p, const Joints& q) {
    const auto turned = [](double word, double from, double to) {
      const double turns = std::max(360.0, std::abs(to - from));
      return std::remainder(word - 0.5 * (from + to), turns) + 0.5 * (to - from);
    };
    const std::array<double, 5> way{q.x - p.x, q.y - p.y, q.z - p.z, q.a - p.a, q.c - p.c},
        at{words.x - p.x, words.y - p.y, words.z - p.z, turned(words.a, p.a, q.a), turned(words.c, p.c, q.c)};
    double square = 0.0, along = 0.0, least = 0.0;
    for (std::size_t i = 0; i < way.size(); ++i) square += way[i] * way[i], along += way[i] * at[i];
    const double share = square > 0.0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
    for (std::size_t i = 0; i < way.size(); ++i) least = std::max(least, std::abs(at[i] - share * way[i]));
    return least;
  };
  const auto raised = [&](Joints at) { return at.z = up.z, at; };
  std::size_t best = 0;  // of the moves
  double least = off(raised(moves.front().joints), moves.front().joints);
  const auto take = [&](std::size_t move, double apart) {
    if (apart < least) least = apart, best = move;
  };
  take(moves.size(), off(moves.back().joints, raised(moves.back().joints)));
  for (std::size_t i = 1; i < moves.size(); ++i)
    if ((moves[i].kind == MoveKind::kRapid) == rapid) take(i, off(moves[i - 1].joints, moves[i].joints));
  if (least > kOffItsMove) return std::nullopt;
  if (best == 0) return LinkPlace{};
  if (best == moves.size()) return LinkPlace{ways.size() - 1};
  const Joints &from = moves[best - 1].joints, &to = moves[best].joints;
  const bool in_run = std::any_of(runs_.begin(), runs_.end(),
                                  [&](const AxisRun& run) { return best >= run.first && best < run.last; });
  // Up to the retract the tool goes where the stretch has ended.
  const bool swings = !runs_.empty() && !in_run && raised(from) != raised(to);
  for (std::size_t i = 0; i < ways.size(); ++i)
    if (ways[i].has(moves[best].move)) return LinkPlace{i, swings};
  return std::nullopt;
}

std::size_t OperationPlan::link_near(Point<Part> tip) const {
  const std::vector<Move>& moves = block_path().moves;
  const std::vector<LinkWay> ways = link_ways(block_path());
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ways.size(); ++i)
    for (std::size_t k = std::max<std::size_t>(ways[i].first, 1); k < ways[i].last; ++k) {
      const double apart = distance_to_segment(tip, moves[k - 1].pose.tip, moves[k].pose.tip);
      if (apart < least) least = apart, best = i;
    }
  return best;
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
  auto joints = joints_of(planned_.path, options, job_.machine.model);
  if (!joints) return note_limit(joints.error(), planned_.path), tl::unexpected(joints.error());
  joints_ = std::move(*joints);
  if (joints_.reconfigured) planned_.path = std::move(*joints_.reconfigured);
  return {};
}

/// A stretch whose rotaries are come to from there, at the retract. `path`: with its reconfigurations then.
Result<JointPath> OperationPlan::joints_behind(const Joints& from, ToolPath& path,
                                               const JointPathOptions& options, const SwingChoice& choice) {
  MachineModel machine = job_.machine.model;
  auto found = joints_of(path, options, machine);
  if (!found) return found;
  stretches_.back().usual = found->moves.front().joints;
  if (choice.other_side) {
    machine.preferred_tilt = stretches_.back().usual.a > machine.tilt.zero ? -1 : 1;
    found = joints_of(path, options, machine);
    if (!found) return found;
  }
  if (found->reconfigured) path = std::move(*found->reconfigured);
  const auto turns = choice.other_way ? turn_round(machine, from, found->moves.front().joints) : std::nullopt;
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
    const SwingChoice& choice = kSwingChoices[begins ? 0 : swings_[link]];
    stretches_.push_back({link, {}});
    auto found = joints_behind(begins ? Joints{} : joints.path.moves.back().joints, part, options, choice);
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
  return planned_program(joints_, runs_, job_, header);
}

}  // namespace tiltfeed::daemon
