#include "pathgen/options/option_checks.h"

#include <cmath>

namespace tiltfeed::pathgen {

Result<void> check_options(const PlanOptions& o) {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (!positive(o.cutter.diameter)) return fail(Code::kInput, "cutter.diameter_mm must be a positive length");
  const bool by_scallop = o.pattern.measure == StepMeasure::kScallop;
  const bool by_levels = o.pattern.kind == PatternKind::kZLevel || o.pattern.kind == PatternKind::kSplit ||
                         o.pattern.kind == PatternKind::kRough;
  if (by_levels && !positive(o.pattern.step_down))
    return fail(Code::kInput, "pattern.step_down_mm must be a positive length");
  if (!(o.smoothing >= 0.0)) return fail(Code::kInput, "points.smoothing_mm must be zero or more");
  if (o.smoothing > 0.0 && (o.pattern.kind == PatternKind::kZLevel || o.pattern.kind == PatternKind::kRough))
    return fail(Code::kInput,
                "points.smoothing_mm raises the tool out of corners: not on the levels of z_level and rough");
  if (by_scallop || o.pattern.kind == PatternKind::kZLevel || o.pattern.kind == PatternKind::kPencil
          ? !(o.pattern.side_step >= 0.0)
          : !positive(o.pattern.side_step))
    return fail(Code::kInput, "pattern.side_step_mm must be a positive length");
  if (by_scallop && !positive(o.pattern.scallop))
    return fail(Code::kInput, "pattern.scallop_mm must be a positive length");
  if (by_scallop && o.cutter.nose_radius() <= 0.0)
    return fail(Code::kInput,
                "pattern.measure scallop needs a rounded cutter: a flat end leaves steps, not scallops; use "
                "measure surface");
  if (o.pattern.measure == StepMeasure::kRidge) {
    if (o.pattern.kind != PatternKind::kRaster || o.axis.mode == AxisMode::kFree)
      return fail(Code::kInput,
                  "pattern.measure ridge is for rows side by side: use kind raster and a predefined axis, or "
                  "another measure");
    if (o.cutter.type != CutterType::kBall || o.radial_stock > 0.0 || o.axial_stock > 0.0)
      return fail(Code::kInput,
                  "pattern.measure ridge is for a cutter of the type ball, and without stock.radial_mm and "
                  "stock.axial_mm; use another measure");
    if (o.smoothing > 0.0)
      return fail(Code::kInput,
                  "pattern.measure ridge does not go with points.smoothing_mm, which leaves more in corners "
                  "than rows do; use another measure");
  }
  if (!positive(o.tolerance)) return fail(Code::kInput, "tolerance_mm must be a positive length");
  if (!positive(o.links.clearance)) return fail(Code::kInput, "clearance_mm must be a positive length");
  if (!(o.allowance >= 0.0)) return fail(Code::kInput, "allowance_mm must be zero or more");
  if (!(o.links.approach >= 0.0)) return fail(Code::kInput, "approach_mm must be zero or more");
  return {};
}

}  // namespace tiltfeed::pathgen
