#include "kinematics/joints/joint_path.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

#include "kinematics/joints/joint_chooser.h"
#include "kinematics/joints/joint_errors.h"
#include "kinematics/joints/move_subdivider.h"
#include "kinematics/joints/operation.h"
#include "kinematics/joints/over_singularity.h"

namespace tiltfeed {

namespace {

// Share of the tolerance that the axis may lose by holding the table near the pole; swinging the table in
// place there costs twice that.
constexpr double kPoleShare = 0.25;
// Moves that one thread walks at a time, and the most such stretches that are under way: enough for many
// threads, few enough to stay in a cache. It begins with one and doubles for as long as foretelling succeeds.
constexpr std::size_t kStretchMoves = 256;
constexpr std::size_t kStretches = 64;
// Room for so many times the blocks that the path's beginning leads one to expect.
constexpr double kSpareRoom = 1.1;
// A beginning says little of the whole: room for no more than so many times the blocks that there are.
constexpr std::size_t kMostGrowth = 4;
// Plans of an operation that are followed before the search is given up: each replaces one rapid more.
constexpr int kMostPlans = 100;

/// What a walk depends on of the moves before.
bool same(const JointSolution& a, const JointSolution& b) {
  return a.joints == b.joints && a.branch == b.branch && a.at_pole == b.at_pole;
}

/// Builds one joint path from one start, many stretches at a time: where each starts is foretold by the
/// rotary words at the moves' ends alone. A stretch that turns out to start elsewhere is walked again, so the
/// path is that of one walk from end to end.
class Follower {
 public:
  Follower(const ToolPath& path, const MachineModel& machine, const JointChooser& chooser,
           const JointPathOptions& options, const std::vector<WayFromPole>& ahead = {})
      : path_(path), machine_(machine), chooser_(chooser), options_(options), ahead_(ahead) {}

  Result<JointPath> follow(const JointSolution& start, const StageProgress& progress);
  /// Where and why it ended early.
  const std::optional<SubdivisionStop>& stop() const { return stop_; }

 private:
  struct Part {
    std::size_t first = 0, count = 0;  ///< moves of the path
    JointSolution start;
    SubdividedMoves stretch;
  };

  void foretell(std::size_t first);
  SubdividedMoves walk(const Part& part, const JointSolution& start) const;
  std::size_t join();
  void append(const SubdividedMoves& stretch);
  void make_room();

  const ToolPath& path_;
  const MachineModel& machine_;
  const JointChooser& chooser_;
  const JointPathOptions& options_;
  std::vector<WayFromPole> ahead_;          ///< by move; empty: nothing is asked
  std::vector<RotarySolutions> solutions_;  ///< of the moves under way
  std::vector<Part> parts_;                 ///< of these moves
  JointSolution at_;                        ///< where the next of them starts
  std::size_t stretches_ = 1;               ///< to foretell next
  JointPath out_;
  std::optional<SubdivisionStop> stop_;
};

/// Divides the moves from `first` on into parts with their starts.
void Follower::foretell(std::size_t first) {
  const std::size_t count = std::min(path_.moves.size() - first, stretches_ * kStretchMoves);
  solutions_.resize(count);
  tbb::parallel_for(std::size_t{0}, count,
                    [&](std::size_t i) { solutions_[i] = chooser_.solve(path_.moves[first + i].pose); });
  for (std::size_t i = 0; i < count && !ahead_.empty(); ++i) solutions_[i].ahead = ahead_[first + i];
  parts_.clear();
  JointSolution at = at_;
  for (std::size_t i = 0; i < count; ++i) {
    const Pose& pose = path_.moves[first + i].pose;
    if (i % kStretchMoves == 0) {
      if (i > 0)
        at = {chooser_.placed(path_.moves[first + i - 1].pose.tip, at.joints.a, at.joints.c), at.branch,
              at.at_pole, false};
      parts_.push_back({first + i, std::min(count - i, kStretchMoves), at, {}});
    }
    const auto next = chooser_.next_rotary(pose, solutions_[i], at);
    if (!next) break;  // the walk knows better, or says why not
    at = *next;
  }
}

SubdividedMoves Follower::walk(const Part& part, const JointSolution& start) const {
  const std::size_t offset = part.first - parts_.front().first;
  return MoveSubdivider(path_, machine_, chooser_, options_)
      .walk(start, part.first, std::span(solutions_).subspan(offset, part.count));
}

void Follower::append(const SubdividedMoves& stretch) {
  out_.moves.insert(out_.moves.end(), stretch.moves.begin(), stretch.moves.end());
  // One by one: a sum of the stretches' sums would be rounded otherwise than that of one walk.
  double seconds = out_.report.seconds;
  for (const JointMove& move : stretch.moves) seconds += move.seconds;
  out_.report.add(stretch.report);
  out_.report.seconds = seconds;
}

/// Room for the blocks at hand and, at their rate so far, for the rest of the path: growing by doubling would
/// hold them twice.
void Follower::make_room() {
  std::size_t blocks = out_.moves.size();
  for (const Part& part : parts_) blocks += part.stretch.moves.size();
  if (blocks <= out_.moves.capacity()) return;
  const auto done = static_cast<double>(parts_.back().first + parts_.back().count);
  const double whole =
      kSpareRoom * static_cast<double>(blocks) * static_cast<double>(path_.moves.size()) / done;
  out_.moves.reserve(std::min(static_cast<std::size_t>(whole) + 1, kMostGrowth * blocks));
}

/// Appends the parts; returns the move to go on with: the next, or the first whose start is foretold wrong
/// after one was already: then all are likely to be.
std::size_t Follower::join() {
  make_room();
  stretches_ = std::min(2 * stretches_, kStretches);
  bool astray = false;
  for (Part& part : parts_) {
    if (!same(part.start, at_)) {
      if (astray) return part.first;
      astray = true;
      stretches_ = 1;
      part.stretch = walk(part, at_);
    }
    append(part.stretch);
    at_ = part.stretch.end;
    stop_ = part.stretch.stop;
    if (stop_) break;
  }
  return parts_.back().first + parts_.back().count;
}

Result<JointPath> Follower::follow(const JointSolution& start, const StageProgress& progress) {
  at_ = start;
  out_.moves.push_back({start.joints, 0.0, MoveKind::kRapid, 0});
  out_.report.min = out_.report.max = start.joints;
  for (std::size_t first = 1; first < path_.moves.size();) {
    if (progress && !progress(static_cast<double>(first) / static_cast<double>(path_.moves.size())))
      return fail(Code::kCancelled, "cancelled; nothing was written");
    foretell(first);
    tbb::parallel_for(std::size_t{0}, parts_.size(),
                      [&](std::size_t k) { parts_[k].stretch = walk(parts_[k], parts_[k].start); });
    first = join();
    if (stop_) return tl::unexpected(stop_->error);
  }
  return std::move(out_);
}

/// The path with the reconfigurations of `plan`, followed. `stopped`: the move of the path as given at which
/// that ends early.
Result<JointPath> reconfigured(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                               const JointChooser& chooser, const JointPathOptions& options,
                               const OperationPlan& plan, const StageProgress& progress,
                               std::optional<std::size_t>& stopped) {
  std::vector<std::uint32_t> planned;
  ToolPath longer = with_reconfigurations(path, machine, setup, plan, options.clear, planned);
  Follower follower(longer, machine, chooser, options);
  auto done = follower.follow(plan.start, progress);
  if (!done) {
    if (follower.stop()) stopped = planned[follower.stop()->move];
    return done;
  }
  done->report.reconfigurations = plan.changes.size();
  done->reconfigured = std::move(longer);
  done->planned = std::move(planned);
  return done;
}

/// The path with the fewest reconfigurations; nothing where none serve. A plan looks at the moves' ends only.
/// A rapid that then breaks a limit between its ends is replaced in the next plan.
Result<std::optional<JointPath>> with_fewest_reconfigurations(const ToolPath& path,
                                                              const MachineModel& machine, const Setup& setup,
                                                              const JointChooser& chooser,
                                                              const JointPathOptions& options,
                                                              const StageProgress& progress) {
  if (!options.clear.height && !options.clear.radius) return std::nullopt;
  std::vector<bool> replaced(path.moves.size(), false);
  for (int tried = 0; tried < kMostPlans; ++tried) {
    const auto plan = plan_operation(path, machine, setup, chooser, options.clear, replaced);
    if (!plan) return std::nullopt;
    std::optional<std::size_t> stopped;
    auto done = reconfigured(path, machine, setup, chooser, options, *plan, progress, stopped);
    if (done) return std::optional(std::move(*done));
    if (done.error().code == Code::kCancelled) return tl::unexpected(done.error());
    if (!stopped || replaced[*stopped] || path.moves[*stopped].kind != MoveKind::kRapid) return std::nullopt;
    replaced[*stopped] = true;
  }
  return std::nullopt;
}

/// The path from the first start that leads through.
Result<JointPath> followed(const ToolPath& path, const MachineModel& machine, const JointChooser& chooser,
                           const JointPathOptions& options, const std::vector<WayFromPole>& ahead,
                           const StageProgress& progress) {
  const Pose& first = path.moves.front().pose;
  RotarySolutions leave = chooser.solve(first);
  for (std::size_t i = 1; leave.in_cone && i < path.moves.size(); ++i) {
    leave = chooser.solve(path.moves[i].pose);
    if (!leave.in_cone && leave.reachable)
      leave = chooser.leaving(path.moves[i - 1].pose, path.moves[i].pose);
  }
  const auto starts = chooser.starts(first, leave.in_cone || !leave.reachable ? nullptr : &leave);
  if (!starts) return tl::unexpected(located(starts.error(), 0, first, machine, chooser.setup()));
  // The first start that leads through; else the error of the one that came furthest. Another turn of the
  // table helps against the table's limit only, another branch against any.
  std::size_t furthest = 0;
  Error error;
  std::array<bool, 2> hopeless{};
  for (const JointSolution& start : *starts) {
    if (hopeless[static_cast<std::size_t>(start.branch)]) continue;
    Follower follower(path, machine, chooser, options, ahead);
    auto done = follower.follow(start, progress);
    if (done || !follower.stop() || done.error().code == Code::kUnreachable) return done;
    hopeless[static_cast<std::size_t>(start.branch)] = !follower.stop()->wound_up;
    if (follower.stop()->move > furthest) {
      furthest = follower.stop()->move;
      error = done.error();
    }
  }
  return tl::unexpected(error);
}

/// The error with the move of the path as given that it names ("move 12, ...").
Error renumbered(const Error& error, const std::vector<std::uint32_t>& planned) {
  constexpr std::string_view kMove = "move ";
  if (!error.message.starts_with(kMove)) return error;
  char* rest = nullptr;
  const auto move = static_cast<std::size_t>(std::strtoull(error.message.c_str() + kMove.size(), &rest, 10));
  if (move >= planned.size()) return error;
  return {error.code, std::string(kMove) + std::to_string(planned[move]) + rest};
}

/// Over the pole in another posture than the nearest: by way of the clear height, or in place.
Result<JointPath> followed_over_the_pole(const ToolPath& path, const MachineModel& machine,
                                         const Setup& setup, const JointChooser& chooser,
                                         const JointPathOptions& options, double cone,
                                         const StageProgress& progress) {
  Result<JointPath> done = fail(Code::kLimit, "the path does not pass the pole within a move");
  for (const bool lift : {true, false}) {
    if (lift && !options.clear.height) continue;
    PathOverSingularity over = over_singularity(path, machine, setup, chooser, options.clear, cone, lift);
    const bool asks = std::any_of(over.ahead.begin(), over.ahead.end(),
                                  [](const WayFromPole& ahead) { return ahead.asks(); });
    if (!over.changed && !asks) break;
    if (auto valid = check_path(over.path, machine, options); !valid) return tl::unexpected(valid.error());
    done = followed(over.path, machine, chooser, options, over.ahead, progress);
    if (!done && done.error().code == Code::kCancelled) return done;
    if (!done) {
      done = tl::unexpected(renumbered(done.error(), over.planned));
      continue;
    }
    done->reconfigured = std::move(over.path);
    done->planned = std::move(over.planned);
    return done;
  }
  return done;
}

}  // namespace

Result<JointPath> to_joints(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                            const JointPathOptions& options, const StageProgress& progress) {
  double cone = Angle::from_degrees(options.axis_tolerance).radians();
  if (path.tool.corner_radius > 0.0) cone = std::min(cone, options.tolerance / path.tool.corner_radius);
  cone *= kPoleShare;
  const JointChooser chooser(machine, setup, options.linear_decimals, options.rotary_decimals, cone);
  if (auto valid = check_path(path, machine, options); !valid) {
    if (!turns_over(path)) return tl::unexpected(valid.error());
    return followed_over_the_pole(path, machine, setup, chooser, options, cone, progress);
  }
  auto direct = followed(path, machine, chooser, options, {}, progress);
  if (direct || direct.error().code != Code::kLimit) return direct;
  // Where that does not serve either, the pose of the planned path is what the user knows.
  auto led = with_fewest_reconfigurations(path, machine, setup, chooser, options, progress);
  if (!led) return tl::unexpected(led.error());
  if (*led) return std::move(**led);
  auto over = followed_over_the_pole(path, machine, setup, chooser, options, cone, progress);
  if (over || over.error().code == Code::kCancelled) return over;
  return direct;
}

}  // namespace tiltfeed
