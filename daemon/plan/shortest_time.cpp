#include "daemon/plan/shortest_time.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tiltfeed::daemon {
namespace {

using pathgen::PatternKind;
using pathgen::StepMeasure;

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

bool measured_by_step(PatternKind kind) {
  return kind == PatternKind::kRaster || kind == PatternKind::kSplit || kind == PatternKind::kContour ||
         kind == PatternKind::kSpiral;
}

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
    try_scallop();
    if (has_direction(own_.job())) try_directions();
    return {std::move(best_), tried_};
  }

 private:
  const config::Job& best_job() const { return best_ ? best_->job() : own_.job(); }

  /// Takes the plan of this pattern where it is quicker and leaves no more.
  void attempt(const pathgen::Pattern& pattern) {
    if (tried_ >= kMostTried) return;
    ++tried_;
    config::Job job = own_.job();
    job.plan.pattern = pattern;
    std::unique_ptr<OperationPlan> plan = plan_(job);
    if (!plan) return;
    const std::optional<Left> left = left_by(*plan);
    if (!left || !within(left->most, left_->most) || !within(left->uncut, left_->uncut)) return;
    if (plan->timing().seconds < seconds_) seconds_ = plan->timing().seconds, best_ = std::move(plan);
  }

  /// The same ridge everywhere: what the step leaves on a plane, or the most that it leaves anywhere where
  /// that is less. The ridge is measured with what the tolerance leaves on it.
  void try_scallop() {
    const pathgen::PlanOptions& stated = own_.job().plan;
    const double rounding = stated.cutter.nose_radius(), half = 0.5 * stated.pattern.side_step;
    const bool steps = measured_by_step(stated.pattern.kind) &&
                       stated.pattern.measure != StepMeasure::kScallop && half > 0.0 && half < rounding;
    if (!steps) return;
    pathgen::Pattern pattern = stated.pattern;
    pattern.measure = StepMeasure::kScallop;
    pattern.side_step = 0.0;
    pattern.scallop =
        std::min(rounding - std::sqrt(rounding * rounding - half * half), left_->most - stated.tolerance);
    if (pattern.scallop > 0.0) attempt(pattern);
  }

  void try_directions() {
    for (const double step : {45.0, 22.5}) {
      const pathgen::Pattern middle = best_job().plan.pattern;
      const int places = step > 30.0 ? 3 : 1;  // all round, then on both sides of the best
      for (int i = 1; i <= places; ++i) turn(middle, i * step);
      if (places == 1) turn(middle, -step);
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
