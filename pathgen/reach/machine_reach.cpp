#include "pathgen/reach/machine_reach.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// A tool axis that is missed by less is reached: what the tolerance of any program forgives, rad.
constexpr double kForgiven = 1e-5;
/// Limits of words are met to the decimals that are printed, degrees.
constexpr double kPrinted = 1e-4;

/// Degrees between the machine's own limit and the one that a job asks for: moves lean over further than
/// their ends.
constexpr double kTiltMargin = 0.5;
/// A direction along the table's z to this (cosine).
constexpr double kStanding = 0.999;

/// The word, by whole turns, that is within the limits; nothing where none is.
std::optional<double> within(const RotaryAxis& axis, double word) {
  if (!axis.present) return word;
  const double first = word + 360.0 * std::ceil((axis.min - kPrinted - word) / 360.0);
  if (!std::isfinite(first)) return word;  // endless
  if (first > axis.max + kPrinted) return std::nullopt;
  return first;
}

bool travels(const LinearAxis& axis, double at) { return at >= axis.min && at <= axis.max; }

}  // namespace

Angle tilt_limit(const MachineModel& machine) {
  const Angle none = Angle::from_degrees(180.0);
  const bool lying = machine.rotary.present && std::abs(machine.rotary.direction.z) < kStanding;
  if (!machine.tilt.present || lying) return none;
  const double low = std::max(machine.tilt.min, machine.tilt.zero - 360.0),
               high = std::min(machine.tilt.max, machine.tilt.zero + 360.0);
  const auto lean = [&](double word) {
    return angle_between(forward(machine, {}, {0.0, 0.0, 0.0, word, 0.0}).axis, {0, 0, 1});
  };
  double most = 0.0;
  for (int k = 0; k <= 720; ++k) most = std::max(most, lean(low + (high - low) * k / 720.0));
  // A tilt alone leans by its limit to one side only, where the other side is longer.
  if (!machine.rotary.present) most = std::min(lean(low), lean(high));
  const double degrees = Angle::from_radians(most).degrees() - kTiltMargin;
  return degrees > 0.0 && degrees < 179.0 ? Angle::from_degrees(degrees) : none;
}

MachineReach::MachineReach(const MachineModel& machine, const Setup& setup, Angle tilt_max)
    : machine_(machine), chain_(machine, setup), least_upright_(std::cos(tilt_max.radians())) {}

std::optional<Reach> MachineReach::refusal(const Pose& pose) const {
  const Vec3 there = chain_.on_table(pose.axis);
  if (there.z < least_upright_ - kForgiven) return Reach::kTilt;
  const AxisSolutions found = chain_.solve_axis(there);
  if (found.missed > kForgiven) return Reach::kTilt;
  Reach why = Reach::kTilt;
  for (const RotaryAngles& at : found.angles) {
    const auto tilt = within(machine_.tilt, chain_.tilt_word(at.tilt));
    const auto rotary = found.rotary_free ? std::optional(chain_.rotary_word(at.rotary))
                                          : within(machine_.rotary, chain_.rotary_word(at.rotary));
    if (!tilt || !rotary) continue;
    why = Reach::kTravel;
    const Vec3 q = chain_.linear(pose.tip, Trig::of(at.tilt), Trig::of(at.rotary));
    if (travels(machine_.x, q.x) && travels(machine_.y, q.y) && travels(machine_.z, q.z)) return std::nullopt;
  }
  return why;
}

}  // namespace tiltfeed::pathgen
