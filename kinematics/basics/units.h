#pragma once
// Strong scalars, only where two units meet: degrees in files and G-code, radians in formulas; mm/min in
// files and G-code, seconds in block times. Lengths are double, mm, everywhere.

#include <compare>
#include <numbers>

namespace tiltfeed {

inline constexpr double kPi = std::numbers::pi;

/// A plane angle. Stored in radians.
class Angle {
 public:
  constexpr Angle() = default;
  static constexpr Angle from_radians(double value) { return Angle(value); }
  static constexpr Angle from_degrees(double value) { return Angle(value * (kPi / 180.0)); }
  constexpr double radians() const { return radians_; }
  constexpr double degrees() const { return radians_ * (180.0 / kPi); }
  constexpr auto operator<=>(const Angle&) const = default;

 private:
  constexpr explicit Angle(double radians) : radians_(radians) {}
  double radians_ = 0.0;
};

constexpr Angle operator+(Angle a, Angle b) { return Angle::from_radians(a.radians() + b.radians()); }
constexpr Angle operator-(Angle a, Angle b) { return Angle::from_radians(a.radians() - b.radians()); }
constexpr Angle operator-(Angle a) { return Angle::from_radians(-a.radians()); }
constexpr Angle operator*(Angle a, double factor) { return Angle::from_radians(a.radians() * factor); }

/// A speed of the tool tip over the part. Stored in mm/min.
class Feed {
 public:
  constexpr Feed() = default;
  static constexpr Feed from_mm_per_min(double value) { return Feed(value); }
  constexpr double mm_per_min() const { return mm_per_min_; }
  constexpr double mm_per_s() const { return mm_per_min_ / 60.0; }
  constexpr auto operator<=>(const Feed&) const = default;

 private:
  constexpr explicit Feed(double mm_per_min) : mm_per_min_(mm_per_min) {}
  double mm_per_min_ = 0.0;
};

}  // namespace tiltfeed
