#pragma once
// What the operations of a job say of shank and holder in stock that is left.

#include <memory>
#include <string>
#include <vector>

#include "daemon/plan/operation_plan.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

using Operations = std::vector<std::unique_ptr<OperationPlan>>;

/// Lets the operations cut the stock in their order, `before` those that are planned only for what they
/// leave. Each of `operations` is told what its shank and holder meet on feed moves, and warns of it. Nothing
/// happens where nobody knows the stock: where the job states no blank, unless an operation asks for `rest`
/// behind a first one that roughs the part's box; and where the first operation of all is not there.
/// Errors: kCancelled.
Result<void> find_stock_contacts(const Operations& before, const Operations& operations, StageClock& clock,
                                 const PlanListener& told);

/// A line for the report: what of it was looked for, and not found. Empty where nothing was, or all is in
/// warnings.
std::string stock_text(const OperationPlan& one);

}  // namespace tiltfeed::daemon
