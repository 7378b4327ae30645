#include "daemon/plan/shortest_time.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tiltfeed::daemon {
namespace {

using pathgen::PatternKind;

/// What the passes leave, mm and mm^2.
struct Left {
  double most = 0.0;   ///< between passes
  double uncut = 0.0;  ///< of what faces the tool
};

/// Nothing where it was not looked for.
std::optional<Left> left_by(const OperationPlan& plan) {
  const pathgen::PlanReport& report = plan.plan_report();
  if (report.uncut) return Left{report.uncut->between.most, report.uncut->area};
  if (report.between) return Left{report.between->most, report.between->area};
  return std::nullopt;
}

bool within(double value, double limit) { return value <= limit * (1.0 + kSameRest) + 1e-9; }

bool has_direction(const config::Job& job) {
  const PatternKind kind = job.plan.pattern.kind;
  const bool rows =
      kind == PatternKind::kRaster || kind == PatternKind::kSplit || kind == PatternKind::kRough;
  return rows && job.plan.axis.mode != pathgen::AxisMode::kFree;
}

class Search {
 public:
  Search(const OperationPlan& own, const PlanOnce& plan)
      : own_(own), plan_(plan), left_(left_by(own)), seconds_(own.timing().seconds) {}

  Shortened run() {
    if (!left_) return {};
    if (has_direction(own_.job())) try_directions();
    return {std::move(best_), tried_};
  }

 private:
  /// Takes the plan of this pattern where it is quicker and leaves no more.
  void attempt(const pathgen::Pattern& pattern) {
    if (tried_ >= kMostTried) return;
    ++tried_;
    config::Job job = own_.job();
    job.plan.pattern = pattern;
    // What it leaves takes longer to find than its time, and is not asked of one that is no quicker.
    std::unique_ptr<OperationPlan> plan = plan_(job, false);
    if (!plan || plan->timing().seconds >= seconds_) return;
    plan = plan_(job, true);
    if (!plan) return;
    const std::optional<Left> left = left_by(*plan);
    if (!left || !within(left->most, left_->most) || !within(left->uncut, left_->uncut)) return;
    seconds_ = plan->timing().seconds, best_ = std::move(plan);
  }

  void try_directions() {
    const pathgen::Pattern stated = own_.job().plan.pattern;
    for (const double degrees : {45.0, 90.0, -45.0}) turn(stated, degrees);
    if (!best_) return;
    const pathgen::Pattern best = best_->job().plan.pattern;
    for (const double degrees : {22.5, -22.5}) turn(best, degrees);
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
