#include "daemon/post/near_singularity.h"

#include <utility>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/tool/move_collision.h"

namespace tiltfeed::daemon {

SingularityBendReport bend_near_singularity(const config::Job& job, const pathgen::CheckedMesh& part,
                                            ToolPath& path) {
  if (job.axis_tolerance.radians() <= 0.0) return {};
  const pathgen::MoveCollision clearance(part.mesh, job.plan);
  SingularityBend bent = bend_at_singularity(
      path, job.machine.model, job.setup, {job.axis_tolerance, ToleranceBudget(job.plan.tolerance).pole()},
      [&](const Pose& from, const Pose& to) { return clearance.clear(from, to); });
  path = std::move(bent.path);
  return bent.report;
}

}  // namespace tiltfeed::daemon
