#include "daemon/plan/shortest_time.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace tiltfeed::daemon {
namespace {

using pathgen::PatternKind;
using pathgen::StepMeasure;

/// Rows by their ridges are about so many times as far apart. Their ends are joined where that is quicker, so
/// far apart as the tool cuts in this time (s).
constexpr double kWiderRows = 2.0, kJoinSeconds = 1.0;
/// Of the scallop that a job states this share is allowed at first: the path stands off a little besides.
constexpr double kFirstRidge = 0.97;
/// Where more is left ridges are lowered to one of these shares, so often, if they saved this share of the
/// time.
constexpr double kLittleLower = 0.93, kLowerRidge = 0.72, kWorthLowering = 0.1;
constexpr int kRidgesTried = 3;
/// Directions that are tried, degrees; and these about the best of them.
constexpr double kAcross = 90.0, kSlanted[] = {45.0, -45.0}, kHalfTurns[] = {22.5, -22.5};
/// Where rows across take so many times as long, those between are not tried.
constexpr double kHopeless = 2.0;
/// So many rows tell which of them are quicker, or those that are this much further apart; so many of these
/// are planned whole.
constexpr double kCoarseRows = 32.0, kFewestRows = 8.0;
/// Few rows that take so many times as long as the job's own may still be quicker as a whole.
constexpr double kPromising = 1.1;
constexpr std::size_t kWholePlans = 3;
/// Of walls so many times as much may be left: which row comes nearest to one is chance.
constexpr double kSameWalls = 1.01;
/// Rows by ridges leave less of walls than even ones, if these leave no more than so many times as much.
constexpr double kLittleWalls = 1.1;
/// The job's own rows are given ridges where the best even ones are not so many times as quick.
constexpr double kNearlyAsQuick = 1.25;
/// Closed rows are joined without turning back where that saves this share of the time, about. Where a little
/// more is left, up to this, lower ridges are tried.
constexpr double kWorthGoingOn = 0.03, kLittleMore = 1.1;
/// A lower ridge leaves the more, and this share of it besides.
constexpr double kSurelyLower = 0.99;
/// Turns of the table that are kept free at either end of its way.
constexpr double kSpareTurns = 1.0;
constexpr double kMostRounds = 1000.0;  // as a job may state
/// Axes are calmed where they cost this share of the time.
constexpr double kWorthCalming = 0.02;
constexpr double kMostCalmDegrees = 30.0;  // as a job may state
/// Of rows that go round the table's axis already (sine of the angle between).
constexpr double kRoundTable = 0.02;

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

/// That passes may leave between them: as much as the job's own, or the scallop that it states.
double most_left(const config::Job& job, const std::optional<Left>& left) {
  return left ? std::max(left->most, std::min(job.plan.pattern.optimise_scallop, left->limit)) : 0.0;
}

bool within(double value, double limit) { return value <= limit * (1.0 + kSameRest) + 1e-9; }

bool has_direction(const config::Job& job) {
  const PatternKind kind = job.plan.pattern.kind;
  const bool rows =
      kind == PatternKind::kRaster || kind == PatternKind::kSplit || kind == PatternKind::kRough;
  return rows && job.plan.axis.mode != pathgen::AxisMode::kFree;
}

/// Rows laid another way; the tool axis at a place is the same.
struct RowsTried {
  pathgen::AxisFrame axis;
  pathgen::Pattern pattern;
  std::uint32_t rounds = 0;  ///< of LinkingOptions
  Angle calm;                ///< of the job
};

/// The job with it.
config::Job job_with(config::Job job, const RowsTried& variant) {
  job.plan.axis = variant.axis, job.plan.pattern = variant.pattern;
  job.plan.links.rounds = variant.rounds, job.calm = variant.calm;
  double& join = job.plan.links.join_distance;
  if (variant.pattern.measure == StepMeasure::kRidge && join > 0.0)
    join = std::max(kWiderRows * join, kJoinSeconds * job.plan.cut_feed.mm_per_s());
  return job;
}

/// Is a few rows' time worth finding?
bool is_coarse_told(const config::Job& job) {
  return job.plan.pattern.kind == PatternKind::kRaster && job.plan.pattern.measure == StepMeasure::kFlat;
}

class Search {
 public:
  Search(const OperationPlan& own, const PlanOnce& plan)
      : own_(own),
        plan_(plan),
        left_(left_by(own)),
        most_left_(most_left(own.job(), left_)),
        stated_{own.job().plan.axis, own.job().plan.pattern, own.job().plan.links.rounds, own.job().calm},
        best_rows_(stated_),
        fewer_(fewer(own.plan_report())),
        seconds_(own.timing().seconds) {}

  Shortened run() {
    if (!left_) return {};
    if (has_direction(own_.job())) {
      if (is_coarse_told(own_.job()))
        try_promising();
      else
        try_directions();
    }
    if (has_ridges(own_.job().plan)) try_ridges();
    if (stated_.rounds == 0) try_rounds();
    if (may_calm()) try_calm();
    return {std::move(best_), tried_};
  }

 private:
  std::unique_ptr<OperationPlan> planned(const config::Job& job, bool rest) {
    if (tried_ >= kMostTried) return nullptr;
    ++tried_;
    return plan_(job, rest);
  }

  /// Why a plan was not taken, and the ridge that was allowed in it.
  struct Refused {
    double ridge = 0.0;
    bool no_area = false;       ///< only at the worst place more is left
    bool little_walls = false;  ///< only of walls more is left, and not much
    double more = 1.0;          ///< so many times as much is left at the worst place
    double saves = 0.0;         ///< share of the time
  };

  /// Takes the plan of this variant where it is quicker and leaves no more. Something where it is quicker and
  /// leaves more.
  std::optional<Refused> attempt(const RowsTried& variant) {
    std::unique_ptr<OperationPlan> plan = planned(job_with(own_.job(), variant), true);
    if (!plan || plan->timing().seconds >= seconds_) return std::nullopt;
    const std::optional<Left> left = left_by(*plan);
    if (!left) return std::nullopt;
    const bool most = within(left->most, most_left_), walls = within(left->walls, kSameWalls * left_->walls),
               others = within(left->over, left_->over) && within(left->uncut, left_->uncut);
    if (!most || !walls || !others)
      return Refused{plan->plan_report().ridge, walls && others,
                     most && others && within(left->walls, kLittleWalls * left_->walls),
                     left->most / most_left_, 1.0 - plan->timing().seconds / seconds_};
    seconds_ = plan->timing().seconds, best_ = std::move(plan), best_rows_ = variant;
    return std::nullopt;
  }

  /// With a few rows.
  double coarse_seconds(const RowsTried& variant) {
    config::Job job = job_with(own_.job(), variant);
    job.plan.pattern.side_step *= fewer_, job.plan.links.join_distance *= fewer_;
    const std::unique_ptr<OperationPlan> plan = planned(job, false);
    return plan ? plan->timing().seconds : std::numeric_limits<double>::infinity();
  }

  /// Whole plans of those variants that a few rows are quick in, the quickest first, until one is taken.
  void try_promising() {
    struct Ranked {
      double seconds;
      RowsTried variant;
    };
    std::vector<Ranked> ranked;
    const double own = coarse_seconds(stated_);
    const auto rank = [&](const RowsTried& variant) {
      const double seconds = coarse_seconds(variant);
      if (seconds < kPromising * own) ranked.push_back({seconds, variant});
      return seconds;
    };
    const auto sort = [&] {
      std::stable_sort(ranked.begin(), ranked.end(),
                       [](const Ranked& a, const Ranked& b) { return a.seconds < b.seconds; });
    };
    if (rank(turned(stated_, kAcross)) < kHopeless * own)
      for (const double degrees : kSlanted) rank(turned(stated_, degrees));
    sort();
    if (!ranked.empty())
      for (const RowsTried best = ranked.front().variant; const double degrees : kHalfTurns)
        rank(turned(best, degrees));
    if (const auto variant = round_the_table()) rank(*variant);
    sort();
    for (std::size_t i = 0; i < ranked.size() && i < kWholePlans && !best_; ++i) {
      const std::optional<Refused> refused = attempt(ranked[i].variant);
      if (refused && refused->little_walls && !nearly_) nearly_ = ranked[i].variant;
    }
  }

  /// All of them as whole plans. What they leave takes longer to find than their time, and is not asked of
  /// those that are no quicker.
  void try_directions() {
    const auto try_one = [&](const RowsTried& variant) {
      const std::unique_ptr<OperationPlan> plan = planned(job_with(own_.job(), variant), false);
      if (plan && plan->timing().seconds < seconds_) attempt(variant);
    };
    for (const double degrees : {kSlanted[0], kAcross, kSlanted[1]}) try_one(turned(stated_, degrees));
    if (best_)
      for (const RowsTried best = best_rows_; const double degrees : kHalfTurns)
        try_one(turned(best, degrees));
    if (const auto variant = round_the_table()) try_one(*variant);
  }

  /// In the best direction, and in the job's own where that may be quicker still: rows as far apart as ridges
  /// allow that are no higher than the job says, or than those of its own rows on most of the surface.
  void try_ridges() {
    const double even = seconds_;
    const bool others = best_ != nullptr || nearly_;
    RowsTried own = stated_;
    own.pattern.measure = StepMeasure::kRidge,
    own.pattern.scallop = kFirstRidge * own.pattern.optimise_scallop;
    if (others && own.pattern.scallop == 0.0) {
      const std::unique_ptr<OperationPlan> plan = planned(job_with(own_.job(), own), false);
      if (!plan) return;
      own.pattern.scallop = plan->plan_report().ridge;
    }
    RowsTried best = best_ == nullptr && nearly_ ? *nearly_ : best_rows_;
    best.pattern.measure = StepMeasure::kRidge, best.pattern.scallop = own.pattern.scallop;
    ridges(best);
    const bool taken = seconds_ < even;
    if (others && (!taken || own_.timing().seconds < kNearlyAsQuick * even)) ridges(own);
  }

  void ridges(RowsTried variant) {
    for (int k = 0; k < kRidgesTried; ++k) {
      const std::optional<Refused> more = attempt(variant);
      if (!more || more->saves < kWorthLowering) return;
      // A single place may leave more by where rows happen to lie; a little less moves them.
      variant.pattern.scallop = more->ridge * (more->no_area && k == 0 ? kLittleLower : kLowerRidge);
    }
  }

  /// Rows that are closed, without turning back at each.
  void try_rounds() {
    const OperationPlan& plan = best_ ? *best_ : own_;
    RowsTried variant = best_rows_;
    variant.rounds = rounds_of(own_.job().machine.model);
    // The table brakes and speeds up again at each: from its mean speed, if it turned all the time.
    const RotaryAxis& table = own_.job().machine.model.rotary;
    const auto rows = static_cast<double>(plan.plan_report().closed_rows);
    const double speed = std::min(table.velocity / 60.0, 360.0 * rows / seconds_);
    if (variant.rounds < 2 || rows * speed / table.acceleration < kWorthGoingOn * seconds_) return;
    const std::optional<Refused> refused = attempt(variant);
    if (!refused || refused->more > kLittleMore || variant.pattern.measure != StepMeasure::kRidge) return;
    variant.pattern.scallop = kSurelyLower * refused->ridge / std::max(1.0, refused->more);
    attempt(variant);
  }

  /// The job lets the axis lean, and nothing but a ball touches.
  bool may_calm() const {
    const pathgen::PlanOptions& plan = own_.job().plan;
    return stated_.calm.radians() == 0.0 && own_.job().axis_tolerance.radians() == 0.0 &&
           plan.lean.limit.radians() > 0.0 && !pathgen::may_lean(plan) &&
           plan.axis.mode != pathgen::AxisMode::kFixed && plan.cutter.type == pathgen::CutterType::kBall &&
           plan.radial_stock == 0.0 && plan.axial_stock == 0.0;
  }

  /// The best plan's axes, turning evenly. Its ball keeps to the same way.
  void try_calm() {
    const OperationPlan& like = best_ ? *best_ : own_;
    const TimeByMotion motion = like.by_motion();
    if (motion.slow_axes + motion.accelerations < kWorthCalming * seconds_) return;
    RowsTried variant = best_rows_;
    variant.calm = Angle::from_degrees(std::min(own_.job().plan.lean.limit.degrees(), kMostCalmDegrees));
    std::unique_ptr<OperationPlan> plan = like.to_be_calmed(variant.calm);
    if (plan) {
      if (tried_++ >= kMostTried || !plan->find_joints()) return;
    } else {
      plan = planned(job_with(own_.job(), variant), false);
      if (plan) plan->leaves_as(like);
    }
    if (!plan || plan->timing().seconds >= seconds_) return;
    seconds_ = plan->timing().seconds, best_ = std::move(plan), best_rows_ = variant;
  }

  std::optional<RowsTried> round_the_table() const {
    const auto frame = round_table(own_.job().plan);
    if (!frame) return std::nullopt;
    RowsTried variant{*frame, stated_.pattern, 0, {}};
    variant.pattern.along = pathgen::Along::kX, variant.pattern.angle = {};
    return variant;
  }

  static double fewer(const pathgen::PlanReport& report) {
    return std::clamp(static_cast<double>(report.retracts + report.joins) / kCoarseRows, 1.0, kFewestRows);
  }

  static RowsTried turned(RowsTried variant, double degrees) {
    Angle& angle = variant.pattern.angle;
    angle = Angle::from_degrees(std::remainder(angle.degrees() + degrees, 180.0));
    return variant;
  }

  const OperationPlan& own_;
  const PlanOnce& plan_;
  const std::optional<Left> left_;
  const double most_left_;  ///< between passes, mm
  const RowsTried stated_;
  RowsTried best_rows_;
  const double fewer_;  ///< so many times as far apart rows are at first
  double seconds_;
  std::unique_ptr<OperationPlan> best_;
  std::optional<RowsTried> nearly_;  ///< which ridges may do for: its even rows left a little more of walls
  std::size_t tried_ = 0;
};

}  // namespace

bool has_ridges(const pathgen::PlanOptions& plan) {
  return plan.pattern.kind == PatternKind::kRaster && plan.pattern.measure == StepMeasure::kFlat &&
         plan.axis.mode != pathgen::AxisMode::kFree && plan.axis.mode != pathgen::AxisMode::kIndexed &&
         plan.cutter.type == pathgen::CutterType::kBall && plan.smoothing == 0.0 &&
         plan.radial_stock == 0.0 && plan.axial_stock == 0.0;
}

std::optional<pathgen::AxisFrame> round_table(const pathgen::PlanOptions& plan) {
  const pathgen::Containment& region = plan.containment;
  if (plan.axis.mode != pathgen::AxisMode::kPoint || region.first.bounded() || region.second.bounded() ||
      !region.boundary.empty())
    return std::nullopt;
  pathgen::AxisFrame frame = plan.axis;
  const double s = static_cast<double>(frame.sense);
  const Vec3 b = cross(frame.n, frame.t) * s;
  if (length(cross(b, plan.up)) < kRoundTable) return std::nullopt;
  const Vec3 pole = dot(b, plan.up) < 0.0 ? -plan.up : plan.up;
  const auto across = [&](Vec3 v) { return v - pole * dot(v, pole); };
  const Vec3 t = across(frame.t), n = across(frame.n);
  // Without zeros that have a sign, as they are told.
  frame.t = normalized(length(t) >= length(n) ? t : n) + Vec3{};
  frame.n = normalized(cross(frame.t, pole * s)) + Vec3{};
  return frame;
}

std::uint32_t rounds_of(const MachineModel& machine) {
  const double turns = (machine.rotary.max - machine.rotary.min) / 360.0;
  return static_cast<std::uint32_t>(std::clamp(std::floor(turns / 2.0 - kSpareTurns), 0.0, kMostRounds));
}

Shortened shorten(const OperationPlan& own, const PlanOnce& plan) { return Search(own, plan).run(); }

}  // namespace tiltfeed::daemon
