#include "daemon/plan/time_report.h"

#include <utility>

#include "daemon/plan/formatted.h"
#include "kinematics/timing/lower_bounds.h"
#include "kinematics/timing/time_by_motion.h"
#include "pathgen/pattern/ridge_rows.h"

namespace tiltfeed::daemon {

namespace {

/// How high ridges may be, where nobody has said so.
std::string ridges_text(const ShortenedOperation& one) {
  if (!one.own_ridges) return "";
  return formatted(
      "ridges are allowed that are no higher than the job's own on %.1f %% of the surface; "
      "pattern.optimise_scallop_mm allows others\n",
      100.0 * pathgen::kRidgeShare);
}

}  // namespace

std::string shortened_text(const std::vector<const OperationPlan*>& operations,
                           const std::vector<ShortenedOperation>& shortened) {
  std::string text;
  for (std::size_t i = 0; i < shortened.size(); ++i) {
    const ShortenedOperation& one = shortened[i];
    const std::string& name = operations[i]->job().operation.name;
    text += "shortest time" + (name.empty() ? name : ", " + name) + ": ";
    if (!one.pattern) {
      text += formatted("none of %zu other plans is quicker and leaves no more\n", one.tried);
      text += ridges_text(one);
      continue;
    }
    text += formatted("%.1f min instead of %.1f, of %zu plans; pattern.angle_deg: %.6g",
                      operations[i]->timing().seconds / 60.0, one.seconds / 60.0, one.tried,
                      one.pattern->angle.degrees());
    if (one.pattern->measure == pathgen::StepMeasure::kRidge)
      text += formatted(", measure: ridge, scallop_mm: %.6g, links.join_distance_mm: %.6g",
                        one.pattern->scallop, one.join_distance);
    if (one.calm.radians() > 0.0) text += formatted(", points.calm_deg: %.6g", one.calm.degrees());
    if (one.rounds > 0) text += formatted(", links.rounds: %u", one.rounds);
    if (one.frame) {
      const Vec3 &t = one.frame->t, &n = one.frame->n;
      text += formatted(", along: x; axis.t: [%.15g, %.15g, %.15g], axis.n: [%.15g, %.15g, %.15g]", t.x, t.y,
                        t.z, n.x, n.y, n.z);
    }
    text += "\n" + ridges_text(one);
  }
  return text;
}

std::string bounds_text(const std::vector<const OperationPlan*>& operations, const MachineModel& machine) {
  LowerBounds all;
  for (const OperationPlan* one : operations) all.add(one->bounds());
  const Joints& axes = all.axes;
  std::string text = formatted(
      "no less than: the path at its feed %.1f min, each block at its feed or slowest axis %.1f min; "
      "axes at full speed X %.1f Y %.1f Z %.1f",
      all.path / 60.0, all.blocks / 60.0, axes.x / 60.0, axes.y / 60.0, axes.z / 60.0);
  for (const auto& [axis, seconds] : {std::pair{&machine.tilt, axes.a}, {&machine.rotary, axes.c}})
    if (axis->present) text += formatted(" %c %.1f", axis->letter, seconds / 60.0);
  return text + " min\n";
}

std::string by_motion_text(const std::vector<const OperationPlan*>& operations) {
  TimeByMotion all;
  for (const OperationPlan* one : operations) all.add(one->by_motion());
  return formatted(
      "where the minutes go: cuts at their feed %.1f, slower by axes at full speed %.1f, by accelerations "
      "%.1f; plunges %.1f; rapids %.1f, swings of rotaries %.1f\n",
      all.cuts_at_feed / 60.0, all.slow_axes / 60.0, all.accelerations / 60.0, all.plunges / 60.0,
      all.rapids / 60.0, all.swings / 60.0);
}

}  // namespace tiltfeed::daemon
