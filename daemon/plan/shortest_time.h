#pragma once
// The pattern with which the machine takes the least time and the passes leave no more than the job's own.

#include <functional>
#include <memory>

#include "daemon/plan/operation_plan.h"

namespace tiltfeed::daemon {

/// Plans the job: path, joints and times. Null where that fails.
using PlanOnce = std::function<std::unique_ptr<OperationPlan>(const config::Job& job)>;

/// What was found.
struct Shortened {
  std::unique_ptr<OperationPlan> plan;  ///< null: none is quicker than the job's own
  std::size_t tried = 0;                ///< plans besides that
};

/// `own`: the job as it is, planned with what it leaves. Tries the ridge that its step leaves on a plane
/// as the measure of its passes, and other directions of them; each plan is like the job's own but for these.
/// Properties: 1 What is taken leaves no more between passes, and no more uncut, than `own` does (kSameRest).
/// 2 It takes less time. 3 At most kMostTried plans are made. 4 The same job gives the same.
Shortened shorten(const OperationPlan& own, const PlanOnce& plan);

/// Two heights or areas are the same within this share.
inline constexpr double kSameRest = 1e-3;
inline constexpr std::size_t kMostTried = 8;

}  // namespace tiltfeed::daemon
