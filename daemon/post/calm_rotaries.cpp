#include "daemon/post/calm_rotaries.h"

#include <utility>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/tool/move_collision.h"

namespace tiltfeed::daemon {

Result<CalmReport> calm_rotaries(const config::Job& job, const pathgen::CheckedMesh& part, ToolPath& path,
                                 const StageProgress& progress) {
  if (job.calm.radians() <= 0.0) return CalmReport{};
  const pathgen::MoveCollision clearance(part.mesh, job.plan);
  Result<CalmPath> calm = calm_axes(
      path, job.plan.up, {job.calm, ToleranceBudget(job.plan.tolerance).pole()},
      [&](const Pose& from, const Pose& to) { return clearance.clear(from, to); }, progress);
  if (!calm) return tl::unexpected<Error>(calm.error());
  path = std::move(calm->path);
  return calm->report;
}

}  // namespace tiltfeed::daemon
