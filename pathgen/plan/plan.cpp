#include "pathgen/plan/plan.h"

#include "pathgen/options/option_checks.h"
#include "pathgen/plan/free_plan.h"
#include "pathgen/plan/indexed.h"
#include "pathgen/plan/likely_cause.h"
#include "pathgen/plan/predefined_axis.h"
#include "pathgen/plan/rejected_points.h"

namespace tiltfeed::pathgen {

namespace {

Result<Plan> plan_by_mode(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  if (options.axis.mode == AxisMode::kIndexed) return plan_indexed(part, options, progress);
  if (options.axis.mode != AxisMode::kFree) return plan_where(part, options, nullptr, progress);
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
