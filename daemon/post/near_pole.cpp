#include "daemon/post/near_pole.h"

#include <utility>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/tool/move_clearance.h"

namespace tiltfeed {

PoleBendReport bend_near_pole(const Job& job, const CheckedMesh& part, ToolPath& path) {
  if (job.axis_tolerance.radians() <= 0.0) return {};
  const MoveClearance clearance(part.mesh, job.plan);
  PoleBend bent = bend_at_pole(path, job.machine.model, job.setup,
                               {job.axis_tolerance, ToleranceBudget(job.plan.tolerance).pole()},
                               [&](const Pose& from, const Pose& to) { return clearance.clear(from, to); });
  path = std::move(bent.path);
  return bent.report;
}

}  // namespace tiltfeed
