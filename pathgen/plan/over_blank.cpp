#include "pathgen/plan/over_blank.h"

#include <limits>

#include "pathgen/tool/blank_solid.h"
#include "pathgen/tool/tool_in_blank.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

}  // namespace

std::function<bool(const Pose&, const Pose&)> meets_blank(const PlanOptions& options,
                                                          const Deformation& map) {
  if (!options.blank || map.frame().mode != AxisMode::kCircle) return {};
  const double height = reference_height(options.cutter);
  return [&map, height, tool = ToolInBlank(options)](const Pose& from, const Pose& to) {
    const double count = tool.steps(from, to);
    for (double k = 0.0; k <= count; ++k) {
      const Vec3 axis = slerp(from.axis, to.axis, k / count);
      const Point<Part> reference = lerp(from.tip, to.tip, k / count) + axis * height;
      const double column =
          map.is_astray(reference, axis) ? -kFar : map.column_length(map.flatten(reference));
      if (column < kFar && tool.stands_in(reference, axis, column)) return true;
    }
    return false;
  };
}

Result<void> begin_off_blank(const std::vector<std::vector<Pass>>& rows, const PlanOptions& options,
                             const Deformation& map, double clearance_z) {
  if (!options.from_blank || map.s() > 0.0) return {};
  for (const auto& row : rows)
    for (const Pass& pass : row) {
      if (pass.empty()) continue;
      for (const EnvelopePoint& end : {pass.front(), pass.back()}) {
        const AxisLine line = map.axis_line(end.flat.x, end.flat.y);
        const Point<Part> over = line.base + line.axis * clearance_z;
        if (!options.blank->holds(over, 0.0)) continue;
        return fail(Code::kInput,
                    "inside work begins in the blank: the tool's place over a pass, " + to_string(over) +
                        ", lies in it, and rapids there would run into stock; state the blank as it is, "
                        "with its hollow (blank.shape: file), or leave blank out");
      }
    }
  return {};
}

}  // namespace tiltfeed::pathgen
