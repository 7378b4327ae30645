#include "sim/removal/swept_body.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace tiltfeed::sim {
namespace {

// Two directions whose sine is below this span no parallelogram worth its slab: the capsules of its sides
// cover it to less than this times its length.
constexpr double kParallel = 1e-9;
// A line whose direction has less than this across a capsule's axis runs along it.
constexpr double kAlongAxis = 1e-14;
// Ends of a line inside a solid of revolution are found to this, mm: below the unit of the stock (dexels.h).
constexpr double kLineError = 1e-7;
constexpr int kMostSteps = 80;

/// A convex function of the place in space: signed distance from a solid standing at a pose, and its
/// gradient.
struct Value {
  double value;
  Vec3 gradient;
};

Value distance_at(const SweptBody& body, Point<Part> p) {
  const Vec3 from = p - body.foot;
  const double h = dot(from, body.along);
  const Vec3 out = from - body.along * h;
  const double r = length(out);
  const Slope s = body.solid->distance(r, h);
  return {s.value, (r > 0.0 ? out * (s.along_r / r) : Vec3{}) + body.along * s.along_h};
}

/// (W3) The least over the way: the distance from the swept solid, with the gradient at that place.
Value least_over_way(const SweptBody& body, Point<Part> p) {
  const auto at = [&](double s) { return distance_at(body, p - body.way * s); };
  const auto slope = [&](const Value& v) { return -dot(v.gradient, body.way); };
  Value first = at(0.0);
  if (slope(first) >= 0.0) return first;
  Value last = at(1.0);
  if (slope(last) <= 0.0) return last;
  double low = 0.0, high = 1.0;
  Value best = first.value < last.value ? first : last;
  for (int step = 0; step < kMostSteps; ++step) {
    const double a = slope(first), b = slope(last);
    double s = (last.value - first.value + a * low - b * high) / (a - b);
    const double floor = first.value + a * (s - low);
    if (floor >= best.value - kLineError) break;
    if (step % 3 == 2 || !(s > low && s < high)) s = 0.5 * (low + high);
    const Value middle = at(s);
    if (middle.value < best.value) best = middle;
    (slope(middle) < 0.0 ? first : last) = middle;
    (slope(middle) < 0.0 ? low : high) = s;
  }
  return best;
}

}  // namespace

SweptBody SweptBody::round(Point<Part> foot, Vec3 along, Vec3 way, double radius, ToolPart part) {
  const Vec3 a = from_origin(foot), grow{radius, radius, radius};
  const Vec3 low = lower(lower(a, a + along), lower(a + way, a + along + way));
  const Vec3 high = upper(upper(a, a + along), upper(a + way, a + along + way));
  return {foot, along, way, radius, nullptr, part, low - grow, high + grow};
}

SweptBody SweptBody::revolved(const Revolved& solid, const Pose& pose, Vec3 way, ToolPart part) {
  const Corner &first = solid.corners().front(), &last = solid.corners().back();
  const double from = first.h - first.radius, to = last.h + last.radius;
  SweptBody body = round(pose.tip + pose.axis * from, pose.axis * (to - from), way, 0.0, ToolPart::kCutter);
  // A disc of this radius across the axis reaches this far along each coordinate.
  const auto reach = [&](double k) { return solid.widest() * std::sqrt(std::max(0.0, 1.0 - k * k)); };
  const Vec3 grow{reach(pose.axis.x), reach(pose.axis.y), reach(pose.axis.z)};
  return {pose.tip, pose.axis, way, 0.0, &solid, part, body.low - grow, body.high + grow};
}

/// What is not nearest to the way of the ball is beside the axis, within a disc across it, or at the upper
/// end.
SweptBody SweptBody::without_ball() const {
  SweptBody body = *this;
  const double whole = length(along);
  if (whole == 0.0) return body;
  const Vec3 a = from_origin(foot), u = along / whole, grow{radius, radius, radius};
  const auto reach = [&](double k) { return radius * std::sqrt(std::max(0.0, 1.0 - k * k)); };
  const Vec3 disc{reach(u.x), reach(u.y), reach(u.z)};
  body.above_ball = true;
  body.low = lower(lower(a, a + way) - disc, lower(a + along, a + along + way) - grow);
  body.high = upper(upper(a, a + way) + disc, upper(a + along, a + along + way) + grow);
  return body;
}

double SweptBody::depth(Point<Part> p) const {
  if (solid != nullptr) return -least_over_way(*this, p).value;
  // The nearest point of the parallelogram: inside it, or on one of its four sides.
  const Vec3 n = cross(along, way), from = p - foot;
  const double nn = squared_length(n);
  double least =
      std::min({distance_to_segment(p, foot, foot + along), distance_to_segment(p, foot, foot + way),
                distance_to_segment(p, foot + way, foot + way + along),
                distance_to_segment(p, foot + along, foot + along + way)});
  if (nn > 0.0) {
    const double a = dot(cross(from, way), n) / nn, b = dot(cross(along, from), n) / nn;
    if (a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0) least = std::abs(dot(from, n)) / std::sqrt(nn);
  }
  return radius - least;
}

LineCutter::LineCutter(const SweptBody& body, Vec3 direction)
    : body_(body), direction_(direction), r2_(body.radius * body.radius) {
  if (body.solid != nullptr) return;
  const double along = length(body.along), way = length(body.way);
  const Vec3 n = cross(body.along, body.way);
  if (along == 0.0 || way == 0.0 || length(n) <= kParallel * along * way) {
    const Vec3 whole = dot(body.along, body.way) >= 0.0 ? body.along + body.way : body.along - body.way;
    const Vec3 start = dot(body.along, body.way) >= 0.0 ? Vec3{} : body.way;
    capsules_[count_++] = capsule(body.foot + start, whole);
    return;
  }
  if (body.above_ball) {
    above_ = body.along, above_slope_ = dot(body.along, direction);
    above_from_ = dot(from_origin(body.foot), above_) + std::min(0.0, dot(body.way, above_));
  }
  const Vec3 across = cross(direction, body.along);
  if (length(across) > kParallel * along) {
    side_ = normalized(across);
    const double at = dot(from_origin(body.foot), side_), by = dot(body.way, side_);
    side_low_ = at + std::min(0.0, by) - body.radius, side_high_ = at + std::max(0.0, by) + body.radius;
  }
  slabs_ = {slab(normalized(n), -body.radius, body.radius),
            slab(cross(body.way, n) / squared_length(n), 0.0, 1.0),
            slab(cross(n, body.along) / squared_length(n), 0.0, 1.0)};
  capsules_[count_++] = capsule(body.foot, body.way);
  capsules_[count_++] = capsule(body.foot, body.along);
  capsules_[count_++] = capsule(body.foot + body.way, body.along);
  capsules_[count_++] = capsule(body.foot + body.along, body.way);
}

LineCutter::Capsule LineCutter::capsule(Point<Part> from, Vec3 along) const {
  Capsule c;
  c.foot = from_origin(from), c.whole = length(along);
  c.unit = c.whole > 0.0 ? along / c.whole : direction_;
  c.along = dot(direction_, c.unit);
  c.square = squared_length(direction_ - c.unit * c.along);
  c.inverse = c.square > kAlongAxis ? 1.0 / c.square : 0.0;
  return c;
}

LineCutter::Slab LineCutter::slab(Vec3 gradient, double low, double high) const {
  const double foot = dot(from_origin(body_.foot), gradient), slope = dot(direction_, gradient);
  return {gradient, foot + low, foot + high, slope != 0.0 ? 1.0 / slope : 0.0};
}

/// (W1) The capsule's cylinder without ends, or the ball at that end which the line passes the cylinder's
/// wall beyond. `sign` -1: where the line enters, 1: leaves; it misses the capsule: -sign infinite.
double LineCutter::border(const Capsule& c, Vec3 origin, double sign) const {
  const Vec3 w = origin - c.foot;
  const double height = dot(w, c.unit), rise = dot(w, direction_), ww = squared_length(w);
  double at = sign * c.along > 0.0 ? kInfinity : -kInfinity, t = -sign * kInfinity;
  if (c.inverse > 0.0) {
    const double b = rise - height * c.along, root2 = b * b - c.square * (ww - height * height - r2_);
    if (root2 < 0.0) return t;
    t = (-b + sign * std::sqrt(root2)) * c.inverse;
    at = height + t * c.along;
    if (at >= 0.0 && at <= c.whole) return t;
  }
  // The ball: its centre's place along the capsule's axis.
  const double end = at < 0.0 ? 0.0 : c.whole, b = rise - c.along * end;
  const double root2 = b * b - (ww + end * (end - 2.0 * height)) + r2_;
  return root2 < 0.0 ? -sign * kInfinity : -b + sign * std::sqrt(root2);
}

/// (W2) Between the parallelogram's two shifted images.
Inside LineCutter::between(Vec3 origin) const {
  Inside inside{-kInfinity, kInfinity};
  for (const Slab& s : slabs_) {
    const double at = dot(origin, s.gradient);
    if (s.inverse == 0.0) {
      if (at < s.low || at > s.high) return {kInfinity, -kInfinity};
      continue;
    }
    const double a = (s.low - at) * s.inverse, b = (s.high - at) * s.inverse;
    inside.enter = std::max(inside.enter, std::min(a, b)),
    inside.leave = std::min(inside.leave, std::max(a, b));
  }
  if (inside.enter > inside.leave) return {kInfinity, -kInfinity};
  return inside;
}

std::optional<Inside> LineCutter::operator()(Point<Part> origin, double low, double high) const {
  if (body_.solid != nullptr) return through_solid(origin, low, high);
  const Vec3 o = from_origin(origin);
  if (const double side = dot(o, side_); side < side_low_ || side > side_high_) return std::nullopt;
  // (W7) The highest place of the stretch over the ball's plane.
  if (dot(o, above_) + above_slope_ * (above_slope_ > 0.0 ? high : low) < above_from_) return std::nullopt;
  bool through = false;  // it is inside at the upper end of the stretch
  if (count_ == 1) {
    // Outside there, and nearest to it there or above: the line misses it in the stretch.
    const Vec3 off = capsules_[0].off(o + direction_ * high);
    through = squared_length(off) < r2_;
    if (!through && dot(off, direction_) <= 0.0) return std::nullopt;
  }
  Inside inside = count_ > 1 ? between(o) : Inside{kInfinity, -kInfinity};
  // Most lines have been cut off below already: they need no second end.
  for (int i = 0; i < count_; ++i) inside.enter = std::min(inside.enter, border(capsules_[i], o, -1.0));
  if (inside.enter >= high) return std::nullopt;
  if (through) return Inside{inside.enter, high};
  for (int i = 0; i < count_; ++i) inside.leave = std::max(inside.leave, border(capsules_[i], o, 1.0));
  if (inside.leave <= low || inside.enter > inside.leave) return std::nullopt;
  return inside;
}

/// The distance along the line is convex: tangents at both ends of a stretch bound it from below, and from
/// outside Newton's steps run to the border without passing it.
std::optional<Inside> LineCutter::through_solid(Point<Part> origin, double low, double high) const {
  const auto at = [&](double t) {
    const Value v = least_over_way(body_, origin + direction_ * t);
    return std::pair(v.value, dot(v.gradient, direction_));
  };
  auto [a, slope_a] = at(low);
  if (a > 0.0 && slope_a >= 0.0) return std::nullopt;
  auto [b, slope_b] = at(high);
  if (b > 0.0 && slope_b <= 0.0) return std::nullopt;
  double from = low, to = high, inner = a <= 0.0 ? low : high;
  for (int step = 0; step < kMostSteps && a > 0.0 && b > 0.0; ++step) {
    // The convex function is above both tangents: where both are above zero there is nothing.
    const double reach_a = from - a / slope_a, reach_b = to - b / slope_b;
    if (reach_a > reach_b) return std::nullopt;
    double t = 0.5 * (reach_a + reach_b);
    const auto [m, slope_m] = at(t);
    if (m <= 0.0) {
      inner = t;
      break;
    }
    if (reach_b - reach_a < kLineError) return std::nullopt;
    if (slope_m < 0.0)
      from = std::max(t, reach_a), a = m, slope_a = slope_m;
    else
      to = t, b = m, slope_b = slope_m;
  }
  const auto border = [&](double outside, double value, double slope, double within) {
    for (int step = 0; step < kMostSteps && value > kLineError; ++step) {
      const double next = slope != 0.0 ? outside - value / slope : within;
      if (std::abs(next - outside) < kLineError) break;
      outside = next;
      std::tie(value, slope) = at(outside);
    }
    return outside;
  };
  return Inside{a > 0.0 ? border(from, a, slope_a, inner) : low,
                b > 0.0 ? border(to, b, slope_b, inner) : high};
}

}  // namespace tiltfeed::sim
