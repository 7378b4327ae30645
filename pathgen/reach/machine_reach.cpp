#include "pathgen/reach/machine_reach.h"

#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// A tool axis that is missed by less is reached: what the tolerance of any program forgives, rad.
constexpr double kForgiven = 1e-5;
/// Limits of words are met to the decimals that are printed, degrees.
constexpr double kPrinted = 1e-4;

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

std::optional<Reach> MachineReach::refusal(const Pose& pose) const {
  const AxisSolutions found = chain_.solve_axis(chain_.on_table(pose.axis));
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
