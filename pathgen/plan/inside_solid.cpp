#include "pathgen/plan/inside_solid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "pathgen/mesh/winding_number.h"

namespace tiltfeed::pathgen {

Result<void> leave_material(const Mesh& mesh, Sense sense, Passes& passes, PlanReport& report) {
  std::atomic<std::uint64_t> dropped{0};
  tbb::parallel_for(std::size_t{0}, passes.rows.size(), [&](std::size_t i) {
    std::erase_if(passes.rows[i], [&](const Pass& pass) {
      if (winding_number(mesh, pass[pass.size() / 2].centre) < 0.5) return false;
      dropped += pass.size();
      return true;
    });
  });
  if (dropped == 0) return {};
  std::uint64_t left = 0;
  passes.top = -std::numeric_limits<double>::infinity();
  for (const std::vector<Pass>& row : passes.rows)
    for (const Pass& pass : row)
      for (const EnvelopePoint& p : pass) ++left, passes.top = std::max(passes.top, p.flat.z);
  const std::string why =
      sense == Sense::kOutward
          ? "the axis round which the circle runs lies in the material, and the tool comes from it: move "
            "axis.origin_mm, or make axis.circle_radius_mm smaller"
          : "the axis point, line or circle lies in the material, and inside work starts from it: move "
            "axis.origin_mm to where the tool's shank shall be, or turn axis.sense";
  if (left == 0) return fail(Code::kUnreachable, why);
  report.warnings.push_back(std::to_string(dropped) + " of " + std::to_string(dropped + left) +
                            " points left out: there " + why);
  return {};
}

}  // namespace tiltfeed::pathgen
