#pragma once
// Speed along one block over time: ramps limited in acceleration and jerk, a stretch at constant speed
// between them. One dimension; lengths and times in whatever units the caller has. (M6)..(M10) in
// sim/motion/README.md.

#include <array>
#include <limits>
#include <optional>

namespace tiltfeed::sim {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Along a path; kUnlimited where nothing is stated.
struct PathLimits {
  double speed = kUnlimited;
  double acceleration = kUnlimited;
  double jerk = kUnlimited;  ///< unlimited: the acceleration jumps (trapezoidal speed)
};

/// Where a motion is along its path.
struct PathState {
  double s = 0.0, v = 0.0, a = 0.0;
};

/// Largest values over some time, as magnitudes.
struct PathPeaks {
  double speed = 0.0, acceleration = 0.0;
  void raise(const PathPeaks& other);
};

/// (M6) Least time and the length of the way for a change of speed with no acceleration at its ends; the same
/// for both directions.
double ramp_seconds(double from, double to, const PathLimits& limits);
double ramp_length(double from, double to, const PathLimits& limits);

/// (M8) The highest speed after `length`, coming with `from`; not less than `from`. It never falls when
/// `from` or `length` grows. PathLimits::speed is not looked at.
double highest_after(double from, double length, const PathLimits& limits);
/// The lowest one, coming with `from`; not more than `from`.
double lowest_after(double from, double length, const PathLimits& limits);

/// Speed over time from one state to another place.
class SpeedProfile {
 public:
  /// (M9) The fastest way to place `end`, arriving with speed `exit` and no acceleration; a speed above the
  /// limit at the start is brought down first. Nothing when `end` is too near for the acceleration at the
  /// start to end. Requires: lowest_after <= exit <= highest_after of what is left when the acceleration has
  /// ended.
  static std::optional<SpeedProfile> to(const PathState& from, double end, double exit,
                                        const PathLimits& limits);
  /// (M10) To a standstill as soon as possible, wherever that is.
  static SpeedProfile halt(const PathState& from, const PathLimits& limits);
  /// With the acceleration ended as soon as possible; where the choice of a new exit speed begins.
  static PathState settled(const PathState& from, const PathLimits& limits);

  double seconds() const { return seconds_; }
  const PathState& end() const { return end_; }
  /// `t` s after the start; at the end from seconds() on.
  PathState at(double t) const;
  /// Over the first `t` s.
  PathPeaks peaks(double t) const;

 private:
  struct Phase {
    double seconds = 0.0, jerk = 0.0;
    PathState from;
  };
  void add(double seconds, double acceleration, double jerk);
  void settle(const PathLimits& limits);
  void ramp(double to, const PathLimits& limits);
  void finish(double s, double v);

  static constexpr int kMostPhases = 8;  // settle, two ramps of three, constant speed
  std::array<Phase, kMostPhases> phases_{};
  int count_ = 0;
  double seconds_ = 0.0;
  PathState end_;
};

}  // namespace tiltfeed::sim
