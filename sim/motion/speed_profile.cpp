#include "sim/motion/speed_profile.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// Newton's method on the cubic of a short ramp and bisections end when nothing changes any more; so many
// steps are more than either ever takes.
constexpr int kMostNewtonSteps = 60, kMostHalvings = 200;

// Share by which a length that is just enough may miss it in floating point: a hundred times the rounding of
// the root that it came from. What is braked within it is that share of the block off its place, far under a
// control's smallest step.
constexpr double kLengthRounding = 1e-9;

double square(double x) { return x * x; }

/// Change of speed at which a ramp just reaches the greatest acceleration: a^2 / j; 0 without a jerk limit.
double full_change(const PathLimits& limits) {
  return limits.jerk < kUnlimited ? square(limits.acceleration) / limits.jerk : 0.0;
}

/// x >= 0 with j x^3 + 2 v x = length: the time of half a short ramp upwards from v.
double short_ramp_up(double v, double length, double j) {
  // Both terms are positive, so the root is below what either alone gives; from there Newton only descends.
  double x = std::cbrt(length / j);
  if (v > 0.0) x = std::min(x, length / (2.0 * v));
  for (int i = 0; i < kMostNewtonSteps; ++i) {
    const double next = x - ((j * x * x + 2.0 * v) * x - length) / (3.0 * j * x * x + 2.0 * v);
    if (!(next < x)) break;
    x = next;
  }
  return x;
}

/// The smaller x >= 0 with 2 v x - j x^3 = length: the time of half a short ramp downwards from v.
double short_ramp_down(double v, double length, double j) {
  double x = length / (2.0 * v);  // below the root; the curve is concave, so Newton only climbs
  for (int i = 0; i < kMostNewtonSteps; ++i) {
    const double slope = 2.0 * v - 3.0 * j * x * x;
    const double next = slope > 0.0 ? x - ((2.0 * v - j * x * x) * x - length) / slope : x;
    if (!(next > x)) break;
    x = next;
  }
  return x;
}

/// (M7) The speed below `high` from which, or to which, a ramp is longest.
double longest_partner(double high, const PathLimits& limits) {
  const double full = full_change(limits);
  return high <= 1.5 * full ? high / 3.0 : full / 2.0;
}

/// (M7) Length that is enough for a ramp between `high` and any speed from `low` to `high`.
double sure_length(double high, double low, const PathLimits& limits) {
  const double partner = limits.jerk < kUnlimited ? std::min(high, longest_partner(high, limits)) : 0.0;
  return ramp_length(high, std::max(low, partner), limits);
}

/// The highest top speed of a block: both ramps fit into `length`. Requires: they do with the larger of both
/// ends.
double top_speed(double entry, double exit, double length, const PathLimits& limits) {
  const double least = std::max(entry, exit);
  const auto fits = [&](double top) {
    return ramp_length(entry, top, limits) + ramp_length(top, exit, limits) <= length;
  };
  if (fits(limits.speed)) return limits.speed;
  const double a = limits.acceleration;
  // Without a jerk limit this is the answer, with one it is never reached.
  const double most = std::sqrt((2.0 * a * length + square(entry) + square(exit)) / 2.0);
  if (limits.jerk == kUnlimited) return std::clamp(most, least, std::max(least, limits.speed));
  double low = least,
         high =
             std::min(limits.speed, a < kUnlimited ? most : least + std::cbrt(square(length) * limits.jerk));
  for (int i = 0; i < kMostHalvings && low < high; ++i) {
    const double middle = low + (high - low) / 2.0;
    if (middle <= low || middle >= high) break;
    (fits(middle) ? low : high) = middle;
  }
  return low;
}

/// The lowest speed in the middle of a block that is entered too fast.
double braked_speed(double entry, double exit, double length, const PathLimits& limits) {
  const auto fits = [&](double middle) {
    return ramp_length(entry, middle, limits) + ramp_length(middle, exit, limits) <= length;
  };
  double low = std::max(limits.speed, exit), high = entry;
  if (low >= high || fits(low)) return low;
  for (int i = 0; i < kMostHalvings; ++i) {
    const double middle = low + (high - low) / 2.0;
    if (middle <= low || middle >= high) break;
    (fits(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

void PathPeaks::raise(const PathPeaks& other) {
  speed = std::max(speed, other.speed);
  acceleration = std::max(acceleration, other.acceleration);
}

double ramp_seconds(double from, double to, const PathLimits& limits) {
  const double change = std::abs(to - from);
  if (change == 0.0) return 0.0;
  if (limits.jerk == kUnlimited) return change / limits.acceleration;
  return change < full_change(limits) ? 2.0 * std::sqrt(change / limits.jerk)
                                      : change / limits.acceleration + limits.acceleration / limits.jerk;
}

double ramp_length(double from, double to, const PathLimits& limits) {
  const double seconds = ramp_seconds(from, to, limits);
  return seconds > 0.0 ? (from + to) / 2.0 * seconds : 0.0;
}

double highest_after(double from, double length, const PathLimits& limits) {
  const double a = limits.acceleration, j = limits.jerk;
  if (length <= 0.0) return from;
  if (j == kUnlimited) return std::sqrt(square(from) + 2.0 * a * length);
  const double full = full_change(limits);
  const auto by_short_ramp = [&] { return from + j * square(short_ramp_up(from, length, j)); };
  if (from >= full / 2.0)
    return length < (2.0 * from + full) * a / j
               ? by_short_ramp()
               : std::sqrt(square(from - full / 2.0) + 2.0 * a * length) - full / 2.0;
  if (length < 4.0 * from * std::sqrt(2.0 * from / j)) return by_short_ramp();
  if (a == kUnlimited || length < 2.0 * full * a / j) return std::cbrt(square(0.75 * length) * 1.5 * j);
  return std::sqrt(2.0 * a * length) - full / 2.0;
}

double lowest_after(double from, double length, const PathLimits& limits) {
  const double a = limits.acceleration, j = limits.jerk;
  if (length <= 0.0 || from <= 0.0) return from;
  if (j == kUnlimited) return std::sqrt(std::max(0.0, square(from) - 2.0 * a * length));
  if (sure_length(from, 0.0, limits) <= length * (1.0 + kLengthRounding)) return 0.0;
  const double full = full_change(limits);
  if (from >= 1.5 * full && length >= (2.0 * from - full) * a / j)
    return full / 2.0 + std::sqrt(std::max(0.0, square(from + full / 2.0) - 2.0 * a * length));
  return std::max(0.0, from - j * square(short_ramp_down(from, length, j)));
}

void SpeedProfile::add(double seconds, double acceleration, double jerk) {
  if (!(seconds > 0.0)) return;
  assert(count_ < kMostPhases);
  end_.a = acceleration;
  phases_[static_cast<std::size_t>(count_++)] = {seconds, jerk, end_};
  end_.s += seconds * (end_.v + seconds * (acceleration / 2.0 + seconds * jerk / 6.0));
  end_.v += seconds * (acceleration + seconds * jerk / 2.0);
  end_.a += seconds * jerk;
  seconds_ += seconds;
}

void SpeedProfile::settle(const PathLimits& limits) {
  if (limits.jerk < kUnlimited && end_.a != 0.0)
    add(std::abs(end_.a) / limits.jerk, end_.a, end_.a > 0.0 ? -limits.jerk : limits.jerk);
  end_.a = 0.0;
  end_.v = std::max(0.0, end_.v);
}

void SpeedProfile::ramp(double to, const PathLimits& limits) {
  const double change = std::abs(to - end_.v), up = to > end_.v ? 1.0 : -1.0;
  if (limits.acceleration < kUnlimited || limits.jerk < kUnlimited) {
    if (limits.jerk == kUnlimited) {
      add(change / limits.acceleration, up * limits.acceleration, 0.0);
    } else {
      const bool full = change >= full_change(limits);
      const double rise = full ? limits.acceleration / limits.jerk : std::sqrt(change / limits.jerk);
      const double peak = full ? limits.acceleration : limits.jerk * rise;
      add(rise, 0.0, up * limits.jerk);
      if (full) add(change / limits.acceleration - rise, up * peak, 0.0);
      add(rise, up * peak, -up * limits.jerk);
    }
  }
  end_.v = to, end_.a = 0.0;
}

/// The end exactly, whatever rounding made of it.
void SpeedProfile::finish(double s, double v) { end_ = {s, v, 0.0}; }

std::optional<SpeedProfile> SpeedProfile::to(const PathState& from, double end, double exit,
                                             const PathLimits& limits) {
  SpeedProfile profile;
  profile.end_ = from;
  profile.settle(limits);
  const double entry = profile.end_.v, length = end - profile.end_.s;
  if (length < 0.0) return std::nullopt;
  if (length == 0.0) {
    profile.finish(end, exit);
    return profile;
  }
  const double middle = entry > limits.speed || exit > limits.speed
                            ? braked_speed(entry, exit, length, limits)
                            : top_speed(entry, exit, length, limits);
  const double even = length - ramp_length(entry, middle, limits) - ramp_length(middle, exit, limits);
  if (middle != entry) profile.ramp(middle, limits);
  if (middle > 0.0 && even > 0.0) profile.add(even / middle, 0.0, 0.0);
  if (exit != middle) profile.ramp(exit, limits);
  profile.finish(end, exit);
  return profile;
}

SpeedProfile SpeedProfile::halt(const PathState& from, const PathLimits& limits) {
  SpeedProfile profile;
  profile.end_ = from;
  profile.settle(limits);
  profile.ramp(0.0, limits);
  return profile;
}

PathState SpeedProfile::settled(const PathState& from, const PathLimits& limits) {
  if (from.a == 0.0) return {from.s, std::max(0.0, from.v), 0.0};
  SpeedProfile profile;
  profile.end_ = from;
  profile.settle(limits);
  return profile.end_;
}

PathState SpeedProfile::at(double t) const {
  for (int i = 0; i < count_; ++i) {
    const Phase& phase = phases_[static_cast<std::size_t>(i)];
    if (t < phase.seconds) {
      const PathState& from = phase.from;
      return {from.s + t * (from.v + t * (from.a / 2.0 + t * phase.jerk / 6.0)),
              from.v + t * (from.a + t * phase.jerk / 2.0), from.a + t * phase.jerk};
    }
    t -= phase.seconds;
  }
  return end_;
}

/// Speed and acceleration are monotonic within a phase.
PathPeaks SpeedProfile::peaks(double t) const {
  PathPeaks peaks;
  for (int i = 0; i < count_ && t > 0.0; ++i) {
    const Phase& phase = phases_[static_cast<std::size_t>(i)];
    const double dt = std::min(t, phase.seconds), v = phase.from.v, a = phase.from.a;
    peaks.raise({v, std::abs(a)});
    peaks.raise({v + dt * (a + dt * phase.jerk / 2.0), std::abs(a + dt * phase.jerk)});
    t -= phase.seconds;
  }
  return peaks;
}

}  // namespace tiltfeed::sim
