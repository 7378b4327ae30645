#include "pathgen/plan/plan.h"

#include "pathgen/options/option_checks.h"
#include "pathgen/plan/free_plan.h"
#include "pathgen/plan/indexed.h"
#include "pathgen/plan/likely_cause.h"
#include "pathgen/plan/predefined_axis.h"
#include "pathgen/plan/rejected_points.h"
#include "pathgen/plan/rest_wanted.h"
#include "pathgen/plan/stock_before.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

namespace {

/// A retract takes about as long as so many clearances at the cutting feed.
constexpr double kRetractClearances = 4.0;
/// Of the cutter's radius: so far apart places of a pass are asked whether they are in the blank.
constexpr double kBlankSpacing = 0.25;

/// How far a pass may go on where nothing is to be cut, in about the time of a retract, mm.
double bridge_of(const PlanOptions& options) {
  return kRetractClearances * options.links.clearance +
         options.links.approach * options.cut_feed.mm_per_min() / options.plunge_feed.mm_per_min();
}

/// Down to which z' rapids may come; nothing where nobody knows the stock. `stock` must outlive it.
decltype(WantedPart::free_from) above(const StockBefore& stock) {
  if (!stock.known()) return {};
  return [&stock](const Deformation& map, Point<Flat> place, double from, double to) {
    return stock.free_from(map, place, from, to);
  };
}

/// All of the passes, with rapids that know what the operations before leave.
Result<Plan> plan_over_stock(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  const StockBefore stock(part, options);
  const WantedPart wanted{.place = {}, .free_from = above(stock)};
  return plan_where(part, options, &wanted, progress);
}

/// The same in place of what is left alone.
Result<Plan> plan_everywhere(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  Result<Plan> planned = plan_over_stock(part, options, progress);
  if (planned) planned->report.rest = RestBefore{.more_than = options.rest_more_than, .all_cut = true};
  return planned;
}

/// Only where more than is wanted is left.
Result<Plan> plan_rest(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  if (options.axis.mode == AxisMode::kFree)
    return fail(Code::kInput, "rest.more_than_mm is not made in the axis mode free; use another axis.mode");
  if (options.axis.mode == AxisMode::kIndexed) return plan_indexed(part, options, progress);
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  if (options.rest_everywhere) return plan_everywhere(part, options, progress);
  std::vector<StageTime> times;
  Stages stages(progress, times);
  if (!stages.begin("rest")) return cancelled();
  const ReportShare share = [&](double f) { return stages.report(f); };
  const auto rest = RestWanted::find(part, options, share);
  if (!rest) return tl::unexpected(rest.error());
  stages.end();
  const Deformation field(options.axis, 1.0);
  WantedPart wanted;
  wanted.place = [&](const EnvelopePoint& p) { return rest->wants(p.centre, field.axis_at(p.centre)); };
  wanted.free_from = above(rest->stock());
  wanted.spacing = rest->spacing();
  wanted.bridge = bridge_of(options);
  Result<Plan> planned = plan_where(part, options, &wanted, progress);
  if (!planned) return planned;
  planned->report.rest = rest->before();
  planned->report.rest->whole = planned->report.pattern_length;
  planned->report.times.insert(planned->report.times.begin(), times.begin(), times.end());
  return planned;
}

/// The first operation of a job that says what it is cut from.
Result<Plan> plan_from_blank(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  StockBefore stock(part, options);
  WantedPart wanted;
  if (options.pattern.kind == PatternKind::kRough) {
    stock.lay_grid();
    wanted.place = [&](const EnvelopePoint& p) {
      return stock.meets(p.centre, p.axis, options.pattern.step_down);
    };
    wanted.bridge = bridge_of(options);
    wanted.spacing = kBlankSpacing * options.cutter.radius();
    wanted.whole = true;
  }
  wanted.free_from = above(stock);
  return plan_where(part, options, &wanted, progress);
}

Result<Plan> plan_by_mode(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  if (options.rest_more_than > 0.0) return plan_rest(part, options, progress);
  if (options.axis.mode == AxisMode::kIndexed) return plan_indexed(part, options, progress);
  if (options.axis.mode != AxisMode::kFree) {
    if (options.from_blank) return plan_from_blank(part, options, progress);
    const bool behind = options.blank && !options.earlier.empty();
    return behind ? plan_over_stock(part, options, progress) : plan_where(part, options, nullptr, progress);
  }
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  Plan plan = plan_without_moves(options);
  if (const auto done = plan_free(part, options, progress, plan); !done)
    return tl::unexpected(with_cause(done.error(), part, options));
  measure(plan.path.moves, plan.report);
  return plan;
}

}  // namespace

Result<Plan> plan(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  Result<Plan> planned = plan_by_mode(part, options, progress);
  if (planned) warn_taper_edge(options, planned->report);
  return planned;
}

}  // namespace tiltfeed::pathgen
