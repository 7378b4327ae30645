#include "daemon/plan/plan_text.h"

#include <algorithm>
#include <cmath>

#include "daemon/plan/feed_report.h"
#include "daemon/plan/formatted.h"
#include "daemon/plan/stock_contacts.h"

namespace tiltfeed::daemon {
namespace {

/// ", A 12 C 34 UNIT" of the rotary axes that the machine has.
std::string turning(const MachineModel& machine, const Joints& q, const char* unit) {
  std::string text;
  for (const auto& [axis, value] : {std::pair{&machine.tilt, q.a}, {&machine.rotary, q.c}})
    if (axis->present) text += formatted("%s %c %.0f", text.empty() ? "," : "", axis->letter, value);
  return text.empty() ? text : text + " " + unit;
}

}  // namespace

std::string motion_text(const MotionOutcome& o) {
  const bool small = o.program.bytes < 1'000'000;
  std::string text = formatted(
      "%llu blocks, %.1f %s, machining time %.1f min, tip within %.4f mm of its path between blocks\n",
      static_cast<unsigned long long>(o.program.blocks),
      static_cast<double>(o.program.bytes) / (small ? 1e3 : 1e6), small ? "kB" : "MB",
      o.timing.seconds / 60.0, o.joints.max_tip_deviation);
  const Joints &v = o.timing.peak_velocity, &a = o.timing.peak_acceleration;
  const MachineModel& m = o.machine;
  text += formatted(
      "peaks: X %.0f Y %.0f Z %.0f mm/min%s; X %.0f Y %.0f Z %.0f mm/s2%s; %llu blocks slowed by "
      "accelerations, "
      "%llu moves subdivided",
      v.x, v.y, v.z, turning(m, v, "degrees/min").c_str(), a.x, a.y, a.z, turning(m, a, "degrees/s2").c_str(),
      static_cast<unsigned long long>(o.timing.slowed),
      static_cast<unsigned long long>(o.joints.subdivided_moves));
  if (m.rotary.present)
    text += formatted(", %c winds up by %.1f turns", m.rotary.letter, rotary_turns(o.joints));
  text += "\n";
  if (o.program.planes > 0)
    text += formatted("in %llu tilted %s of the control: come to from the retract each\n",
                      static_cast<unsigned long long>(o.program.planes),
                      o.program.planes == 1 ? "plane" : "planes");
  if (!o.program.plane_offsets.empty())
    text += formatted("work offsets %d to %d: each plane has its own, set all to part zero\n",
                      o.program.plane_offsets.front().offset, o.program.plane_offsets.back().offset);
  if (o.program.arcs > 0)
    text += formatted("%llu arcs, instead of %llu straight blocks\n",
                      static_cast<unsigned long long>(o.program.arcs),
                      static_cast<unsigned long long>(o.program.arcs_stand_for));
  if (o.joints.reconfigurations > 0)
    text += formatted(
        "warning: the tool is taken off the part %llu times to turn %c back or %c over: look for marks\n",
        static_cast<unsigned long long>(o.joints.reconfigurations), m.rotary.letter, m.tilt.letter);
  if (o.starved.count > 0)
    text += formatted(
        "warning: blocks %zu to %zu (%.1f s) come faster than the link carries them, the machine waits for "
        "%.1f s: "
        "use a link of %.0f bytes/s, a larger tolerance_mm, or a lower feed\n",
        o.starved.first + 1, o.starved.first + o.starved.count, o.starved.seconds, o.starved.waits,
        std::ceil(o.starved.bytes_per_s));
  if (o.program.clamped_feeds > 0)
    text += formatted(
        "warning: %llu blocks would need a larger inverse-time F than the control takes: they run slower\n",
        static_cast<unsigned long long>(o.program.clamped_feeds));
  return text;
}

namespace {

/// The path, what it leaves, and what the axes do.
std::string path_text(const OperationPlan& one) {
  const pathgen::PlanReport& plan = one.plan_report();
  std::string text;
  for (const std::string& w : plan.warnings) text += "warning: " + w + "\n";
  text += formatted(
      "%llu facets, %llu passes, %llu points (of %llu), %.1f m cut, %.1f m rapid, %llu retracts\n",
      static_cast<unsigned long long>(plan.facets), static_cast<unsigned long long>(plan.passes),
      static_cast<unsigned long long>(plan.points), static_cast<unsigned long long>(plan.slice_points),
      plan.cut_length / 1000.0, plan.rapid_length / 1000.0, static_cast<unsigned long long>(plan.retracts));
  if (plan.free)
    text += formatted(
        "free axis: %llu CL points, %llu directions tested, %llu breaks, %.2f %% of the slices out of "
        "reach\n",
        static_cast<unsigned long long>(plan.free->cl_points),
        static_cast<unsigned long long>(plan.free->directions),
        static_cast<unsigned long long>(plan.free->breaks),
        100.0 * plan.free->unreached_length / plan.free->cl_length);
  if (plan.lean)
    text += formatted(
        "lean: the tool leans from the axis of the mode on %.1f mm of the passes, by up to %.2f degrees; "
        "%.1f mm are left out\n",
        plan.lean->length, plan.lean->largest.degrees(), plan.lean->left);
  if (plan.indexed)
    text += formatted(
        "indexed: %zu directions reach %.1f %% of the surface, all directions together %.1f %%\n",
        plan.indexed->directions.size(), 100.0 * plan.indexed->reached, 100.0 * plan.indexed->reachable);
  if (plan.rest)
    text += formatted("rest: before it more than %.4g mm is left on %.1f mm2, %.3f mm at most\n",
                      plan.rest->more_than, plan.rest->area, plan.rest->most);
  if (plan.uncut && plan.uncut->area > 0.0)
    text += formatted(
        "uncut: %.1f of %.1f mm2 that face the tool, on %zu facets; which and why is in the report\n",
        plan.uncut->area, plan.uncut->facing_area, plan.uncut->facets.size());
  const pathgen::BetweenPasses* between = plan.uncut     ? &plan.uncut->between
                                          : plan.between ? &*plan.between
                                                         : nullptr;
  if (between != nullptr && between->area == 0.0 && between->limit > 0.0)
    text += formatted("between passes at most %.4f mm are left; %.4f mm are asked, tolerance included\n",
                      between->most, between->limit);
  text += stock_text(one);
  const SingularityBendReport& bend = one.bend();
  if (bend.stretches + bend.refused > 0)
    text += formatted(
        "near the pole the axis leans by up to %.2f degrees at %zu points of %zu pieces; %zu pieces stay "
        "exact, "
        "as the tool is not clear there\n",
        bend.largest.degrees(), bend.points, bend.stretches, bend.refused);
  if (one.calm().points > 0)
    text += formatted("for even turns the axis leans by up to %.2f degrees at %zu points\n",
                      one.calm().largest.degrees(), one.calm().points);
  return text;
}

/// The joints' figures of all operations as those of one program.
JointPathReport joints_of_all(const std::vector<const OperationPlan*>& operations) {
  JointPathReport all = operations.front()->joints().report;
  for (std::size_t i = 1; i < operations.size(); ++i) all.add(operations[i]->joints().report);
  return all;
}

}  // namespace

std::string report_text(const PlanOutcome& o) {
  std::string text;
  double wall = 0.0, tolerance = 0.0;
  for (const pathgen::StageTime& t : o.times) wall += t.seconds;
  for (const OperationPlan* one : o.operations) {
    const config::Job& job = one->job();
    tolerance = std::max(tolerance, whole_tolerance(job));
    if (!job.operation.name.empty())
      text += formatted("operation %zu of %zu, ", job.operation.number, job.operation.count) +
              job.operation.name +
              (job.program.tool > 0 ? ", tool " + std::to_string(job.program.tool) : "") +
              formatted(": %zu blocks, %.1f min\n", one->joints().moves.size(), one->timing().seconds / 60.0);
    text += path_text(*one);
  }
  const config::Job& job = o.operations.front()->job();
  text += motion_text({job.machine.model, joints_of_all(o.operations), o.program, o.timing, o.starved});
  text += shortened_text(o.operations, o.shortened) + feeds_text(o.feeds, o.operations);
  text += by_motion_text(o.operations) + bounds_text(o.operations, job.machine.model);
  for (const OperationPlan* one : o.operations)
    if (one->turn()) text += start_turn_text(*one->turn(), one->job());
  text += o.proof
              ? formatted("proven: %llu moves, nowhere deeper than %.4f mm in the part (tolerance %.4g mm)\n",
                          static_cast<unsigned long long>(o.proof->moves), o.proof->gouge, tolerance)
              : "not proven, as --no-proof says\n";
  if (o.proof) text += o.proof->collisions + "\n";
  text += formatted("%.2f s (%.2f s processor), %.0f MB", wall, o.cpu_seconds, o.peak_memory_mb);
  for (const pathgen::StageTime& t : o.times) text += formatted("; %s %.2f s", t.stage.c_str(), t.seconds);
  return text + "\n";
}

}  // namespace tiltfeed::daemon
