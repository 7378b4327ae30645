#include "sim/solid/triangle.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// Below this squared sine two directions count as parallel: the closed form would divide by it, and the end
// points, which are tested anyway, are then as near as the inside.
constexpr double kParallel = 1e-24;

bool over_face(const Triangle& t, Vec3 from_a) {
  const double v = dot(t.grad_v, from_a), w = dot(t.grad_w, from_a);
  return v >= 0.0 && w >= 0.0 && v + w <= 1.0;
}

bool has_area(const Triangle& t) { return t.normal != Vec3{}; }
bool owns(const Triangle& t, int bit) { return (t.owned >> bit & 1) != 0; }

Segment edge(const Triangle& t, int i) {
  const Point<Part> b = t.a + t.ab, c = t.a + t.ac;
  if (i == 0) return {t.a, b};
  return i == 1 ? Segment{b, c} : Segment{c, t.a};
}

double squared_distance_to_segment(const Segment& s, Point<Part> p) {
  const Vec3 along = s.to - s.from, m = p - s.from;
  const double whole = squared_length(along);
  const double f = whole > 0.0 ? std::clamp(dot(m, along) / whole, 0.0, 1.0) : 0.0;
  return squared_length(m - along * f);
}

double touch_sphere(Vec3 m, Vec3 direction, double radius, double bound) {
  const double gap = squared_length(m) - radius * radius;
  if (gap <= 0.0) return 0.0;
  const double along = dot(m, direction);
  if (along >= 0.0) return bound;
  const double half = radius * radius - squared_length(m - direction * along);
  return half < 0.0 ? bound : std::min(bound, -along - std::sqrt(half));
}

double touch_cylinder(Vec3 m, Vec3 direction, Vec3 whole, double radius, double bound) {
  const double size = length(whole);
  if (size == 0.0) return bound;
  const Vec3 u = whole / size;
  const double m_u = dot(m, u), d_u = dot(direction, u);
  const Vec3 m_across = m - u * m_u, d_across = direction - u * d_u;
  const double gap = squared_length(m_across) - radius * radius;
  if (gap <= 0.0) return m_u >= 0.0 && m_u <= size ? 0.0 : bound;
  const double speed = squared_length(d_across), closing = dot(m_across, d_across);
  if (closing >= 0.0 || speed < kParallel) return bound;
  // Distance of the centre's line from the edge, across both, decides whether they meet at all.
  const double half = radius * radius - squared_length(m_across - d_across * (closing / speed));
  if (half < 0.0) return bound;
  const double s = -closing / speed - std::sqrt(half / speed);
  const double at = m_u + s * d_u;
  return at >= 0.0 && at <= size ? std::min(bound, std::max(s, 0.0)) : bound;
}

}  // namespace

Triangle make_triangle(Point<Part> a, Point<Part> b, Point<Part> c, std::uint32_t facet) {
  Triangle t{a, b - a, c - a, {}, {}, {}, facet, 0x3F};
  const Vec3 n = cross(t.ab, t.ac);
  const double twice_area = length(n);
  if (twice_area <= 0.0) return t;
  t.normal = n / twice_area;
  t.grad_v = cross(t.ac, t.normal) / twice_area;
  t.grad_w = cross(t.normal, t.ab) / twice_area;
  return t;
}

double squared_distance(const Triangle& t, Point<Part> p) {
  const Vec3 m = p - t.a;
  double best = kInfinity;
  if (has_area(t) && over_face(t, m)) {
    const double h = dot(t.normal, m);
    best = h * h;
  }
  for (int i = 0; i < 3; ++i)
    if (owns(t, i)) best = std::min(best, squared_distance_to_segment(edge(t, i), p));
  return best;
}

double squared_distance(const Triangle& t, const Segment& s) {
  double best = kInfinity;
  if (has_area(t)) {
    const Vec3 from = s.from - t.a, to = s.to - t.a;
    const double h_from = dot(t.normal, from), h_to = dot(t.normal, to);
    if (h_from * h_to <= 0.0 && h_from != h_to &&
        over_face(t, from + (to - from) * (h_from / (h_from - h_to))))
      return 0.0;
    if (over_face(t, from)) best = h_from * h_from;
    if (over_face(t, to)) best = std::min(best, h_to * h_to);
  }
  for (int i = 0; i < 3; ++i)
    if (owns(t, i)) best = std::min(best, squared_distance(edge(t, i), s));
  return best;
}

double squared_distance(const Segment& a, const Segment& b) {
  const Vec3 u = a.to - a.from, v = b.to - b.from, w = a.from - b.from;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
  if (vv == 0.0) return squared_distance_to_segment(a, b.from);
  if (uu == 0.0) return squared_distance_to_segment(b, a.from);
  const double across = uu * vv - uv * uv;
  double f = across > kParallel * uu * vv ? std::clamp((uv * vw - vv * uw) / across, 0.0, 1.0) : 0.0;
  double g = (uv * f + vw) / vv;
  if (g < 0.0 || g > 1.0) {
    g = std::clamp(g, 0.0, 1.0);
    f = std::clamp((uv * g - uw) / uu, 0.0, 1.0);
  }
  return squared_length(w + u * f - v * g);
}

double first_touch(const Triangle& t, Point<Part> centre, Vec3 direction, double radius, double bound) {
  const Vec3 m = centre - t.a;
  if (has_area(t)) {
    const double h = dot(t.normal, m),
                 closing = h > 0.0 ? -dot(t.normal, direction) : dot(t.normal, direction);
    if (std::abs(h) <= radius) {
      if (over_face(t, m)) return 0.0;
    } else {
      // The whole rounded triangle lies between the two planes at +-radius: not before the nearer of them.
      if (closing <= 0.0) return bound;
      const double s = (std::abs(h) - radius) / closing;
      if (s >= bound) return bound;
      if (over_face(t, m + direction * s)) return s;
    }
  }
  const Vec3 corners[3] = {{}, t.ab, t.ac};
  for (int i = 0; i < 3; ++i) {
    const Vec3 from = corners[i], to = corners[(i + 1) % 3];
    if (owns(t, i)) bound = touch_cylinder(m - from, direction, to - from, radius, bound);
    if (owns(t, 3 + i)) bound = touch_sphere(m - from, direction, radius, bound);
  }
  return bound;
}

double solid_angle(const Triangle& t, Point<Part> p) {
  const Vec3 a = t.a - p, b = a + t.ab, c = a + t.ac;
  const double la = length(a), lb = length(b), lc = length(c);
  return 2.0 *
         std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

}  // namespace tiltfeed::sim
