#include "pathgen/free_slices/normal_cap.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

constexpr double kWidened = 1e-6;
/// Cosine of the widest angle: far enough from 90 degrees for a cone to be convex.
constexpr double kWidest = 0.2;

}  // namespace

std::array<double, 2> NormalCap::along(Vec3 direction) const {
  if (cosine <= -1.0) return {-1.0, 1.0};
  if (sine == 0.0) return {dot(axis, direction), dot(axis, direction)};
  const double c = dot(axis, direction), s = std::sqrt(std::max(0.0, 1.0 - c * c)) * sine;
  return {c <= -cosine ? -1.0 : c * cosine - s, c >= cosine ? 1.0 : c * cosine + s};
}

NormalCap cap_of(Vec3 axis, double angle) {
  if (std::cos(angle) < kWidest) return {};
  return {axis, std::cos(angle + kWidened), std::sin(angle + kWidened)};
}

NormalCap cap_about(const std::vector<Vec3>& normals) {
  Vec3 sum{};
  for (const Vec3 n : normals) sum = sum + n;
  if (!(squared_length(sum) > 0.0)) return {};
  const Vec3 axis = normalized(sum);
  double widest = 0.0;
  for (const Vec3 n : normals) widest = std::max(widest, angle_between(axis, n));
  return cap_of(axis, widest);
}

}  // namespace tiltfeed::pathgen
