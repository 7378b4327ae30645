#include "kinematics/timing/speed_ramp.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {
namespace {

constexpr int kMostSteps = 100;
// Roots are known to this share of themselves.
constexpr double kRootError = 1e-12;

/// Where a function that grows over [low, high], negative at `low`, is zero: the secant, whose end that stays
/// counts half (Illinois). `value_low`, `value_high`: at the ends.
template <class Function>
double root(double low, double high, double value_low, double value_high, const Function& function) {
  int side = 0;
  for (int i = 0; i < kMostSteps && high - low > kRootError * high; ++i) {
    double middle = (low * value_high - high * value_low) / (value_high - value_low);
    if (!(middle > low && middle < high)) middle = 0.5 * (low + high);
    const double value = function(middle);
    if (value == 0.0) return middle;
    if (value < 0.0) {
      low = middle, value_low = value;
      if (side == -1) value_high *= 0.5;
      side = -1;
    } else {
      high = middle, value_high = value;
      if (side == 1) value_low *= 0.5;
      side = 1;
    }
  }
  return low;
}

/// The change of speed from which on a ramp is at the greatest acceleration for a while.
double whole_change(const RampLimits& limits) {
  return limits.jerk < kNoLimit ? limits.acceleration * limits.acceleration / limits.jerk : 0.0;
}

/// The speed below `high` from which a ramp to it is the longest.
double slowest_start(double high, const RampLimits& limits) {
  const double whole = whole_change(limits);
  return high <= 1.5 * whole ? high / 3.0 : 0.5 * whole;
}

}  // namespace

double ramp_time(double change, const RampLimits& limits) {
  if (!(change > 0.0)) return 0.0;
  if (limits.jerk == kNoLimit) return change / limits.acceleration;
  if (change < whole_change(limits)) return 2.0 * std::sqrt(change / limits.jerk);
  return change / limits.acceleration + limits.acceleration / limits.jerk;
}

double ramp_way(double from, double to, const RampLimits& limits) {
  return 0.5 * (from + to) * ramp_time(std::abs(to - from), limits);
}

double reached_speed(double from, double way, const RampLimits& limits) {
  const double a = limits.acceleration, j = limits.jerk;
  if (a == kNoLimit && j == kNoLimit) return kNoLimit;
  const double even = a < kNoLimit ? std::sqrt(from * from + 2.0 * a * way) : kNoLimit;
  if (j == kNoLimit) return even;
  const auto over = [&](double high) {
    return ramp_way(std::max(from, std::min(high, slowest_start(high, limits))), high, limits) - way;
  };
  // Without a limit of the acceleration a ramp is shorter: what such a one reaches is a bound, too.
  const double most = std::min(even, from + std::cbrt(way * way * j));
  const double value = over(most);
  return value <= 0.0 ? most : root(from, most, -way, value, over);
}

double peak_speed(double from, double to, double way, double most, const RampLimits& limits) {
  const double least = std::max(from, to);
  if (limits.acceleration == kNoLimit && limits.jerk == kNoLimit) return most;
  const auto over = [&](double peak) {
    return ramp_way(from, peak, limits) + ramp_way(peak, to, limits) - way;
  };
  double high = most;
  if (limits.acceleration < kNoLimit)
    high = std::min(high, std::sqrt(0.5 * (2.0 * limits.acceleration * way + from * from + to * to)));
  if (limits.jerk < kNoLimit) high = std::min(high, least + std::cbrt(way * way * limits.jerk));
  if (high <= least) return least;
  const double value = over(high);
  if (value <= 0.0) return high;
  const double value_low = over(least);
  return value_low >= 0.0 ? least : root(least, high, value_low, value, over);
}

}  // namespace tiltfeed
