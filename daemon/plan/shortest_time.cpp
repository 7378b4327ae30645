#include "daemon/plan/shortest_time.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace tiltfeed::daemon {
namespace {

using pathgen::PatternKind;
using pathgen::StepMeasure;

/// Rows by their ridges are about so many times as far apart.
constexpr double kWiderRows = 2.0;
/// Of the largest ridge of the job's own rows this share is allowed at first; where more is left, the ridge
/// is lowered to the other share or less, so often.
constexpr double kFirstRidge = 0.97, kLowerRidge = 0.85, kLowestRidge = 0.3;
constexpr int kRidgesTried = 3;
/// By so many times what is left too much.
constexpr double kLowered = 1.2;

/// What the passes leave, mm and mm^2.
struct Left {
  double most = 0.0;   ///< between passes
  double limit = 0.0;  ///< of that, by the job
  double over = 0.0;   ///< where it is over the limit
  double walls = 0.0;  ///< of walls that rows do not follow, mm^3
  double uncut = 0.0;  ///< of what faces the tool
};

/// Nothing where it was not looked for.
std::optional<Left> left_by(const OperationPlan& plan) {
  const pathgen::PlanReport& report = plan.plan_report();
  const auto of = [](const pathgen::BetweenPasses& between, double uncut) {
    return Left{between.most, between.limit, between.area, between.walls, uncut};
  };
  if (report.uncut) return of(report.uncut->between, report.uncut->area);
  if (report.between) return of(*report.between, 0.0);
  return std::nullopt;
}

bool within(double value, double limit) { return value <= limit * (1.0 + kSameRest) + 1e-9; }

bool has_direction(const config::Job& job) {
  const PatternKind kind = job.plan.pattern.kind;
  const bool rows =
      kind == PatternKind::kRaster || kind == PatternKind::kSplit || kind == PatternKind::kRough;
  return rows && job.plan.axis.mode != pathgen::AxisMode::kFree;
}

/// May rows go as far apart as ridges allow?
bool has_ridges(const config::Job& job) {
  const pathgen::PlanOptions& plan = job.plan;
  return plan.pattern.kind == PatternKind::kRaster && plan.pattern.measure == StepMeasure::kFlat &&
         plan.axis.mode != pathgen::AxisMode::kFree && plan.axis.mode != pathgen::AxisMode::kIndexed &&
         plan.cutter.type == pathgen::CutterType::kBall && plan.smoothing == 0.0 &&
         plan.radial_stock == 0.0 && plan.axial_stock == 0.0;
}

class Search {
 public:
  Search(const OperationPlan& own, const PlanOnce& plan)
      : own_(own), plan_(plan), left_(left_by(own)), seconds_(own.timing().seconds) {}

  Shortened run() {
    if (!left_) return {};
    if (has_direction(own_.job())) try_directions();
    if (has_ridges(own_.job())) try_ridges();
    return {std::move(best_), tried_};
  }

 private:
  /// Takes the plan of this pattern where it is quicker and leaves no more. What it leaves where it is
  /// quicker and leaves more.
  std::optional<Left> attempt(const pathgen::Pattern& pattern) {
    if (tried_ >= kMostTried) return std::nullopt;
    ++tried_;
    config::Job job = own_.job();
    job.plan.pattern = pattern;
    // Ends of neighbours are further apart, too.
    if (pattern.measure == StepMeasure::kRidge) job.plan.links.join_distance *= kWiderRows;
    // What it leaves takes longer to find than its time, and is not asked of one that is no quicker. Of rows
    // by their ridges it takes less than the rows do.
    const bool at_once = pattern.measure == StepMeasure::kRidge;
    std::unique_ptr<OperationPlan> plan = plan_(job, at_once);
    if (!plan || plan->timing().seconds >= seconds_) return std::nullopt;
    if (!at_once) plan = plan_(job, true);
    if (!plan) return std::nullopt;
    const std::optional<Left> left = left_by(*plan);
    if (!left) return std::nullopt;
    if (!within(left->most, left_->most) || !within(left->over, left_->over) ||
        !within(left->walls, left_->walls) || !within(left->uncut, left_->uncut))
      return left;
    seconds_ = plan->timing().seconds, best_ = std::move(plan);
    return std::nullopt;
  }

  void try_directions() {
    const pathgen::Pattern stated = own_.job().plan.pattern;
    for (const double degrees : {45.0, 90.0, -45.0}) turn(stated, degrees);
    if (!best_) return;
    const pathgen::Pattern best = best_->job().plan.pattern;
    for (const double degrees : {22.5, -22.5}) turn(best, degrees);
  }

  /// In the best direction and the job's own: rows as far apart as its largest ridge allows. That was found
  /// at some places; others may keep a little more.
  void try_ridges() {
    const pathgen::Pattern own = own_.job().plan.pattern;
    std::vector<pathgen::Pattern> patterns{best_ ? best_->job().plan.pattern : own};
    if (best_) patterns.push_back(own);
    const double first = kFirstRidge * std::min(left_->most, left_->limit);
    for (pathgen::Pattern& pattern : patterns) {
      pattern.measure = StepMeasure::kRidge, pattern.scallop = first;
      for (int k = 0; k < kRidgesTried && pattern.scallop > kLowestRidge * first; ++k) {
        const std::optional<Left> more = attempt(pattern);
        if (!more) break;
        const double lower = kLowerRidge * pattern.scallop, excess = more->most - left_->most;
        // A single place may leave much more. If it does so again, the ridge is lowered by that.
        pattern.scallop = k == 0 ? lower : std::min(lower, pattern.scallop - kLowered * excess);
      }
    }
  }

  void turn(pathgen::Pattern pattern, double degrees) {
    pattern.angle = Angle::from_degrees(std::remainder(pattern.angle.degrees() + degrees, 180.0));
    attempt(pattern);
  }

  const OperationPlan& own_;
  const PlanOnce& plan_;
  const std::optional<Left> left_;
  double seconds_;
  std::unique_ptr<OperationPlan> best_;
  std::size_t tried_ = 0;
};

}  // namespace

Shortened shorten(const OperationPlan& own, const PlanOnce& plan) { return Search(own, plan).run(); }

}  // namespace tiltfeed::daemon
