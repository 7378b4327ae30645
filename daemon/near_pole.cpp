#include "daemon/near_pole.h"

#include <utility>

#include "pathgen/move_clearance.h"

namespace tiltfeed {
namespace {

// The bend's share of the job's tolerance: what planning and post leave for rounding.
constexpr double kBendShare = 0.1;

}  // namespace

PoleBendReport bend_near_pole(const Job& job, const CheckedMesh& part, ToolPath& path) {
  if (job.axis_tolerance.radians() <= 0.0) return {};
  const MoveClearance clearance(part.mesh, job.plan);
  PoleBend bent =
      bend_at_pole(path, job.machine.model, job.setup, {job.axis_tolerance, job.plan.tolerance * kBendShare},
                   [&](const Pose& from, const Pose& to) { return clearance.clear(from, to); });
  path = std::move(bent.path);
  return bent.report;
}

}  // namespace tiltfeed
