#pragma once
// Vectors, points and rotations. Right-handed frames throughout; a positive rotation about an axis is
// counter-clockwise seen from the axis's tip. Lengths mm, angles rad.

#include <algorithm>
#include <array>
#include <cmath>

namespace tiltfeed {

/// A displacement or direction; belongs to no frame by itself.
struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;
  constexpr bool operator==(const Vec3&) const = default;
};

constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(Vec3 a, double k) { return {a.x * k, a.y * k, a.z * k}; }
constexpr Vec3 operator*(double k, Vec3 a) { return a * k; }
constexpr Vec3 operator/(Vec3 a, double k) { return {a.x / k, a.y / k, a.z / k}; }
constexpr double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double squared_length(Vec3 a) { return dot(a, a); }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }
/// Requires: a is not zero.
inline Vec3 normalized(Vec3 a) { return a / length(a); }
inline bool is_finite(Vec3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }
/// Angle between two non-zero vectors, 0..pi, exact near 0 and pi.
inline double angle_between(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

/// Unit vector on the great circle from a to b at fraction f in [0, 1]. Requires: a, b unit, not opposite.
inline Vec3 slerp(Vec3 a, Vec3 b, double f) {
  const double whole = angle_between(a, b);
  if (whole < 1e-12) return a;
  return normalized(a * (std::sin((1.0 - f) * whole) / std::sin(whole)) +
                    b * (std::sin(f * whole) / std::sin(whole)));
}

/// The frames a point can belong to; points of two frames do not mix.
struct Part {};          ///< as in the STL, after the unit scale
struct Flat {};          ///< deformed space: every tool axis is +z'
struct MachineSpace {};  ///< fixed to the machine's bed

template <class Space>
struct Point {
  double x = 0.0, y = 0.0, z = 0.0;
  constexpr bool operator==(const Point&) const = default;
};

template <class S>
constexpr Vec3 operator-(Point<S> a, Point<S> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class S>
constexpr Point<S> operator+(Point<S> p, Vec3 v) {
  return {p.x + v.x, p.y + v.y, p.z + v.z};
}
template <class S>
constexpr Point<S> operator-(Point<S> p, Vec3 v) {
  return {p.x - v.x, p.y - v.y, p.z - v.z};
}
template <class S>
double distance(Point<S> a, Point<S> b) {
  return length(a - b);
}
/// The point at fraction f from a to b.
template <class S>
constexpr Point<S> lerp(Point<S> a, Point<S> b, double f) {
  return a + (b - a) * f;
}
/// Distance of p from the segment from a to b (which may be a point).
template <class S>
double distance_to_segment(Point<S> p, Point<S> a, Point<S> b) {
  const Vec3 ab = b - a, ap = p - a;
  const double ll = squared_length(ab);
  const double f = ll > 0.0 ? std::clamp(dot(ap, ab) / ll, 0.0, 1.0) : 0.0;
  return length(ap - ab * f);
}
/// Distance of p from the triangle with the unit normal n.
template <class S>
double distance_to_triangle(Point<S> p, const std::array<Point<S>, 3>& corner, Vec3 n) {
  const auto& [u, v, w] = corner;
  const bool over = dot(cross(n, v - u), p - u) >= 0.0 && dot(cross(n, w - v), p - v) >= 0.0 &&
                    dot(cross(n, u - w), p - w) >= 0.0;
  if (over) return std::abs(dot(n, p - u));
  return std::min({distance_to_segment(p, u, v), distance_to_segment(p, v, w), distance_to_segment(p, w, u)});
}
template <class S>
constexpr Vec3 from_origin(Point<S> p) {
  return {p.x, p.y, p.z};
}
template <class S>
bool is_finite(Point<S> p) {
  return is_finite(from_origin(p));
}

/// A rotation, row-major.
struct Rotation {
  std::array<Vec3, 3> rows{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  constexpr bool operator==(const Rotation&) const = default;
};

constexpr Vec3 operator*(const Rotation& r, Vec3 v) {
  return {dot(r.rows[0], v), dot(r.rows[1], v), dot(r.rows[2], v)};
}
constexpr Rotation transposed(const Rotation& r) {
  return {{Vec3{r.rows[0].x, r.rows[1].x, r.rows[2].x}, Vec3{r.rows[0].y, r.rows[1].y, r.rows[2].y},
           Vec3{r.rows[0].z, r.rows[1].z, r.rows[2].z}}};
}
constexpr Rotation operator*(const Rotation& a, const Rotation& b) {
  const Rotation bt = transposed(b);
  Rotation product;
  for (int i = 0; i < 3; ++i)
    product.rows[i] = {dot(a.rows[i], bt.rows[0]), dot(a.rows[i], bt.rows[1]), dot(a.rows[i], bt.rows[2])};
  return product;
}
/// Rotation by `angle` (rad) about the unit vector `axis` [Rodrigues].
inline Rotation rotation_about(Vec3 axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), k = 1.0 - c;
  const Vec3 u = axis;
  return {{Vec3{c + u.x * u.x * k, u.x * u.y * k - u.z * s, u.x * u.z * k + u.y * s},
           Vec3{u.y * u.x * k + u.z * s, c + u.y * u.y * k, u.y * u.z * k - u.x * s},
           Vec3{u.z * u.x * k - u.y * s, u.z * u.y * k + u.x * s, c + u.z * u.z * k}}};
}

}  // namespace tiltfeed
