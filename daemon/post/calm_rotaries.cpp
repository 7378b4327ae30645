#include "daemon/post/calm_rotaries.h"

#include <utility>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/tool/move_collision.h"

namespace tiltfeed::daemon {

CalmReport calm_rotaries(const config::Job& job, const pathgen::CheckedMesh& part, ToolPath& path) {
  if (job.calm.radians() <= 0.0) return {};
  const pathgen::MoveCollision clearance(part.mesh, job.plan);
  CalmPath calm = calm_axes(path, job.plan.up, {job.calm, ToleranceBudget(job.plan.tolerance).pole()},
                            [&](const Pose& from, const Pose& to) { return clearance.clear(from, to); });
  path = std::move(calm.path);
  return calm.report;
}

}  // namespace tiltfeed::daemon
