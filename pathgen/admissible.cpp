#include "pathgen/admissible.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {

namespace {

/// An axis steeper than this against the surface normal (cosine of 89 degrees) would cut with its side alone.
constexpr double kAlongSurface = 0.0175;
/// Round the best direction those of the finest level are asked that are nearer to it than this, rad.
constexpr double kAround = 0.15;
/// Directions turned to the tilt limit stay this much (rad) within it: beyond 90 degrees the great circle
/// between two of one tilt dips below them, and by less than this where it is up to 25 degrees long.
constexpr double kWithinTilt = 0.01;

}  // namespace

Admissibility::Admissibility(const SweptTool& tool, const DirectionGrid& grid, Vec3 up, Angle tilt_max)
    : tool_(tool), grid_(grid), up_(up), tilt_max_(tilt_max.radians()), tilt_cosine_(std::cos(tilt_max_)) {}

bool Admissibility::within_limits(Vec3 normal, Vec3 axis) const {
  return dot(normal, axis) >= kAlongSurface && within_tilt(axis);
}

bool Admissibility::admits(const ClPoint& point, Vec3 axis, DirectionQuery& query) const {
  if (!within_limits(point.normal, axis)) return false;
  ++query.tested;
  return !tool_.stop(point.centre, axis, query.hint);
}

std::vector<std::uint32_t> Admissibility::directions(const ClPoint& point, DirectionQuery& query) const {
  const std::uint32_t coarse = DirectionGrid::count(kAdmissibleLevel),
                      fine = DirectionGrid::count(kAdmissibleLevel + 1);
  const std::vector<Vec3>& all = grid_.directions();
  std::vector<std::uint32_t> found;
  std::vector<std::uint8_t> clear(coarse, 0);
  for (std::uint32_t i = 0; i < coarse; ++i)
    if (admits(point, all[i], query)) clear[i] = 1, found.push_back(i);
  const bool none = found.empty();
  for (std::uint32_t i = coarse; i < fine; ++i) {
    const auto [a, b] = grid_.parents(i);
    if ((none || clear[a] != clear[b]) && admits(point, all[i], query)) found.push_back(i);
  }
  return found;
}

std::vector<std::uint32_t> Admissibility::directions_near(const ClPoint& point, Vec3 wished, double window,
                                                          DirectionQuery& query) const {
  const std::uint32_t coarse = DirectionGrid::count(kAdmissibleLevel),
                      fine = DirectionGrid::count(kAdmissibleLevel + 1);
  const std::vector<Vec3>& all = grid_.directions();
  const double widest = std::cos(std::min(window, kPi));
  std::vector<std::uint32_t> found;
  std::uint32_t nearest = fine;
  for (std::uint32_t i = 0; i < coarse; ++i) {
    if (dot(all[i], wished) < widest || !admits(point, all[i], query)) continue;
    found.push_back(i);
    if (nearest == fine || dot(all[i], wished) > dot(all[nearest], wished)) nearest = i;
  }
  if (found.empty()) return directions(point, query);
  const Vec3 best = all[nearest];
  const double round = std::cos(kAround), reached = dot(best, wished);
  for (std::uint32_t i = coarse; i < fine; ++i)
    if (dot(all[i], best) >= round && dot(all[i], wished) > reached && admits(point, all[i], query))
      found.push_back(i);
  return found;
}

bool Admissibility::any_clear(const ClPoint& point, int parts, DirectionQuery& query) const {
  const std::uint32_t count = DirectionGrid::count(kAdmissibleLevel + 1);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 axis = grid_.directions()[i];
    if (dot(point.normal, axis) < kAlongSurface) continue;
    ++query.tested;
    if (!tool_.stop(point.centre, axis, query.hint, parts)) return true;
  }
  return false;
}

Unreached Admissibility::why_none(const ClPoint& point, DirectionQuery& query) const {
  if (tilt_max_ < kPi && any_clear(point, 3, query)) return Unreached::kTilt;
  if (!any_clear(point, 1, query)) return Unreached::kCutter;
  return any_clear(point, 2, query) ? Unreached::kHolder : Unreached::kShank;
}

Vec3 Admissibility::nearest_tilt(Vec3 axis) const {
  if (tilt_max_ >= kPi) return axis;
  const double within = std::max(0.0, tilt_max_ - kWithinTilt);
  if (angle_between(axis, up_) <= within) return axis;
  const Vec3 aside = axis - up_ * dot(axis, up_);
  const Vec3 out = squared_length(aside) > 1e-18
                       ? normalized(aside)
                       : normalized(cross(up_, std::abs(up_.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  return up_ * std::cos(within) + out * std::sin(within);
}

}  // namespace tiltfeed
