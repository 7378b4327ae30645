#include <algorithm>

#include "config/enum_words.h"
#include "config/job_keys.h"
#include "config/key_ranges.h"

namespace tiltfeed::config {
namespace {

constexpr Range kLean = between(-85.0, 85.0);  // degrees; further would cut with the side of the tool
constexpr double kDefaultTurn =
    25.0;  // degrees over the cutter's radius: a small cutter rolls over edges faster
constexpr std::size_t kMaxStacks = 8;

}  // namespace

void read_free_axis(const Section& root, const Section& axis, pathgen::FreeAxis& free,
                    const pathgen::Cutter& cutter) {
  if (cutter.type != pathgen::CutterType::kBall && cutter.type != pathgen::CutterType::kTaperBall)
    root.complain("cutter",
                  "the type " + std::string(word(kCutterWords, cutter.type)) +
                      " has no one CL surface for all tool axes, which the mode free needs; use ball or "
                      "taper_ball");
  free.plane_normals = axis.directions("plane_normals", kMaxStacks);
  free.lead = Angle::from_degrees(axis.number("lead_deg", kLean, 0.0));
  free.lean = Angle::from_degrees(axis.number("lean_deg", kLean, 0.0));
  free.smoothing = axis.number("smoothing_mm", kSmoothing, cutter.radius());
  free.max_turn = Angle::from_degrees(axis.number("max_turn_deg_per_mm", kMaxTurn, 0.0));
}

Angle default_turn(const MachineModel& machine, const pathgen::Cutter& cutter, Feed feed) {
  const double radius = cutter.radius();
  const double tilt = machine.tilt.velocity * length(cross(machine.tilt.direction, machine.spindle));
  const double fastest =
      Angle::from_degrees(std::min(tilt, machine.rotary.velocity) / feed.mm_per_min()).radians();
  const double kept = fastest / (1.0 + radius * fastest);
  return Angle::from_radians(std::min({kept, Angle::from_degrees(kDefaultTurn).radians() / radius,
                                       Angle::from_degrees(kMaxTurn.max).radians()}));
}

void set_default_turns(const MachineModel& machine, pathgen::PlanOptions& plan) {
  const bool is_free = plan.axis.mode == pathgen::AxisMode::kFree;
  if (!is_free && plan.lean.limit.radians() <= 0.0) return;
  Angle& turn = is_free ? plan.free.max_turn : plan.lean.max_turn;
  if (turn.radians() == 0.0) turn = default_turn(machine, plan.cutter, plan.cut_feed);
}

pathgen::RapidRates rapid_rates(const MachineModel& machine) {
  constexpr double kSeconds = 60.0;  // a minute
  pathgen::RapidRates rates;
  rates.linear = {std::min({machine.x.velocity, machine.y.velocity, machine.z.velocity}) / kSeconds,
                  std::min({machine.x.acceleration, machine.y.acceleration, machine.z.acceleration})};
  if (machine.tilt.present) rates.tilt = {machine.tilt.velocity / kSeconds, machine.tilt.acceleration};
  if (machine.rotary.present) rates.table = {machine.rotary.velocity / kSeconds, machine.rotary.acceleration};
  return rates;
}

}  // namespace tiltfeed::config
