#include "pathgen/axis/deformation.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

namespace {

/// Cosine between a tool and the axis at its reference; less: the column there is another's.
constexpr double kOwnColumn = 1.0 - 1e-9;

double sign_of(const AxisFrame& frame) {
  assert(frame.mode != AxisMode::kFree);
  assert(frame.mode != AxisMode::kIndexed);
  return frame.mode == AxisMode::kFixed ? 1.0 : static_cast<int>(frame.sense);
}

}  // namespace

Deformation::Deformation(const AxisFrame& frame, double scale_radius)
    : frame_(frame),
      b_(cross(frame.n, frame.t) * sign_of(frame)),
      s_(sign_of(frame)),
      scale_x_(1.0),
      scale_y_(1.0) {
  assert(frame.mode == AxisMode::kFixed || scale_radius > 0.0);
  if (frame.mode == AxisMode::kPoint || frame.mode == AxisMode::kCircle) {
    scale_x_ = frame.circle_radius_or_zero() + scale_radius;
    scale_y_ = scale_radius;
  } else if (frame.mode == AxisMode::kLine) {
    scale_y_ = scale_radius;
  }
}

Point<Flat> Deformation::flatten(Point<Part> p) const {
  const Vec3 d = p - frame_.origin;
  const double pt = dot(d, frame_.t), pn = dot(d, frame_.n), pb = dot(d, b_);
  switch (frame_.mode) {
    case AxisMode::kFixed:  // (D4)
      return {pt, pb, pn};
    case AxisMode::kLine:  // (D2)
      return {pt, scale_y_ * std::atan2(pb, pn), s_ * std::sqrt(pb * pb + pn * pn)};
    case AxisMode::kPoint:
    case AxisMode::kCircle:
    case AxisMode::kFree:
    case AxisMode::kIndexed:
      break;
  }
  // (D1), (D3): the point mode is the circle mode with R_i = 0.
  const double g = std::sqrt(pt * pt + pn * pn) - frame_.circle_radius_or_zero();
  return {scale_x_ * std::atan2(pt, pn), scale_y_ * std::atan2(pb, g), s_ * std::sqrt(g * g + pb * pb)};
}

AxisLine Deformation::axis_line(double x, double y, Angles& angles) const {
  const auto turn_x = [&] {
    if (x == angles.x) return;
    angles.x = x, angles.sin_x = std::sin(x / scale_x_), angles.cos_x = std::cos(x / scale_x_);
  };
  const auto turn_y = [&] {
    if (y == angles.y) return;
    angles.y = y, angles.sin_y = std::sin(y / scale_y_), angles.cos_y = std::cos(y / scale_y_);
  };
  switch (frame_.mode) {
    case AxisMode::kFixed:
      return {frame_.origin + frame_.t * x + b_ * y, frame_.n};
    case AxisMode::kLine:
      turn_y();
      return {frame_.origin + frame_.t * x, (frame_.n * angles.cos_y + b_ * angles.sin_y) * s_};
    case AxisMode::kPoint:
    case AxisMode::kCircle:
    case AxisMode::kFree:
    case AxisMode::kIndexed:
      break;
  }
  turn_x(), turn_y();
  const Vec3 out = frame_.n * angles.cos_x + frame_.t * angles.sin_x;
  return {frame_.origin + out * frame_.circle_radius_or_zero(),
          (out * angles.cos_y + b_ * angles.sin_y) * s_};
}

Point<Part> Deformation::unflatten(Point<Flat> f) const {
  const AxisLine line = axis_line(f.x, f.y);
  return line.base + line.axis * f.z;
}

Deformation::Distances Deformation::distances(Point<Part> p) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (frame_.mode == AxisMode::kFixed) return {kNone, kNone};
  const Vec3 d = p - frame_.origin;
  const double pt = dot(d, frame_.t), pn = dot(d, frame_.n), pb = dot(d, b_);
  if (frame_.mode == AxisMode::kLine) return {std::sqrt(pb * pb + pn * pn), kNone};
  const double r = std::sqrt(pt * pt + pn * pn), g = r - frame_.circle_radius_or_zero();
  return {std::sqrt(g * g + pb * pb), r};
}

/// A place in the half-plane through the axis of Theta (mode line: in the plane square to the line) that
/// holds it. Reciprocals are 0 where the length is, or has no limit.
struct Deformation::Section {
  double rho = 0.0, per_rho = 0.0, r = 0.0, per_r = 0.0;
  double pt = 0.0, pn = 0.0;
  double cosine = 0.0, sine = 0.0;  ///< of the angle about the point, line or circle: Ph, on a line Th
  Vec3 out;                         ///< where that angle is 0
};

[[gnu::always_inline]] inline Deformation::Section Deformation::section(Point<Part> p) const {
  const auto inverse = [](double v) { return v > 0.0 ? 1.0 / v : 0.0; };
  const Vec3 d = p - frame_.origin;
  const double pb = dot(d, b_);
  Section s;
  s.pt = dot(d, frame_.t), s.pn = dot(d, frame_.n);
  double g = s.pn;
  if (frame_.mode == AxisMode::kLine) {
    s.r = std::numeric_limits<double>::infinity(), s.out = frame_.n;
  } else {
    s.r = std::sqrt(s.pt * s.pt + s.pn * s.pn), s.per_r = inverse(s.r);
    s.out = frame_.t * (s.pt * s.per_r) + frame_.n * (s.pn * s.per_r);
    g = s.r - frame_.circle_radius_or_zero();
  }
  s.rho = std::sqrt(g * g + pb * pb), s.per_rho = inverse(s.rho);
  s.cosine = g * s.per_rho, s.sine = pb * s.per_rho;
  return s;
}

Deformation::Aim Deformation::aim(Point<Part> p) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (frame_.mode == AxisMode::kFixed) return {{kNone, kNone}, frame_.n};
  const Section s = section(p);
  return {{s.rho, s.r}, (s.out * s.cosine + b_ * s.sine) * s_};
}

Deformation::Tangent Deformation::tangent(Point<Part> p) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (frame_.mode == AxisMode::kFixed) return {{{kNone, kNone}, frame_.n}, frame_.t, b_};
  const Section s = section(p);
  const Aim aim{{s.rho, s.r}, (s.out * s.cosine + b_ * s.sine) * s_};
  const Vec3 y = (b_ * s.cosine - s.out * s.sine) * (scale_y_ * s.per_rho);
  if (frame_.mode == AxisMode::kLine) return {aim, frame_.t, y};
  const double turn = scale_x_ * s.per_r * s.per_r;
  return {aim, frame_.t * (s.pn * turn) - frame_.n * (s.pt * turn), y};
}

Deformation::Bend Deformation::bend(Distances least, double radius) const {
  if (frame_.mode == AxisMode::kFixed) return {0.0, 0.0, 0.0};
  const double half_square = radius * radius / 2.0, per_rho = 1.0 / least.rho;
  const double per_r = 1.0 / least.r;  // 0 on a line
  return {scale_x_ * half_square * per_r * per_r, scale_y_ * half_square * per_rho * (per_rho + per_r),
          half_square * (per_rho + per_r)};
}

Vec3 Deformation::axis_at(Point<Part> p) const {
  if (frame_.mode == AxisMode::kFixed) return frame_.n;
  const Vec3 d = p - frame_.origin;
  const Vec3 along = frame_.t * dot(d, frame_.t);
  Vec3 from = d;  // from the nearest place of the point, line or circle
  if (frame_.mode == AxisMode::kLine) from = d - along;
  if (frame_.mode == AxisMode::kCircle) {
    const Vec3 ground = along + frame_.n * dot(d, frame_.n);
    from = d - ground * (frame_.circle_radius / length(ground));
  }
  const double rho = length(from);
  if (rho > 0.0) return from * (s_ / rho);  // not so where the axis is not defined
  const Point<Flat> f = flatten(p);
  return axis_line(f.x, f.y).axis;
}

Vec3 Deformation::axis_turn(Point<Flat> f, Vec3 v) const {
  if (frame_.mode == AxisMode::kFixed) return {};
  const double theta = frame_.mode == AxisMode::kLine ? f.y / scale_y_ : f.x / scale_x_, rho = f.z * s_;
  if (frame_.mode == AxisMode::kLine) {
    const Vec3 round = b_ * std::cos(theta) - frame_.n * std::sin(theta);
    return round * (s_ * dot(round, v) / rho);
  }
  const double phi = f.y / scale_y_;
  const Vec3 out = frame_.n * std::cos(theta) + frame_.t * std::sin(theta);
  const Vec3 round = frame_.t * std::cos(theta) - frame_.n * std::sin(theta);
  const Vec3 over = b_ * std::cos(phi) - out * std::sin(phi);
  const double from_axis = frame_.circle_radius_or_zero() + rho * std::cos(phi);
  return over * (s_ * dot(over, v) / rho) + round * (s_ * dot(round, v) * std::cos(phi) / from_axis);
}

Deformation::Steps Deformation::steps(Point<Flat> f) const {
  if (frame_.mode == AxisMode::kFixed) return {frame_.t, b_};
  const double rho = f.z * s_;
  if (frame_.mode == AxisMode::kLine) {
    const double theta = f.y / scale_y_;
    return {frame_.t, (b_ * std::cos(theta) - frame_.n * std::sin(theta)) * (rho / scale_y_)};
  }
  const double theta = f.x / scale_x_, phi = f.y / scale_y_;
  const Vec3 out = frame_.n * std::cos(theta) + frame_.t * std::sin(theta);
  const Vec3 round = frame_.t * std::cos(theta) - frame_.n * std::sin(theta);
  return {round * ((frame_.circle_radius_or_zero() + rho * std::cos(phi)) / scale_x_),
          (b_ * std::cos(phi) - out * std::sin(phi)) * (rho / scale_y_)};
}

Deformation::Stretch Deformation::stretch(double rho) const {
  if (frame_.mode == AxisMode::kFixed) return {1.0, 1.0};
  const double y = rho / scale_y_;
  if (frame_.mode == AxisMode::kLine) return {1.0, y};
  return {(frame_.circle_radius_or_zero() + rho) / scale_x_, y};
}

double Deformation::column_length(Point<Flat> f) const {
  if (frame_.mode == AxisMode::kFixed) return std::numeric_limits<double>::infinity();
  if (s_ < 0.0) return -f.z;
  const double inwards = frame_.mode == AxisMode::kCircle ? -std::cos(f.y / scale_y_) : 0.0;
  return inwards > 0.0 ? frame_.circle_radius / inwards - f.z : std::numeric_limits<double>::infinity();
}

bool Deformation::is_astray(Point<Part> p, Vec3 axis) const {
  return frame_.mode == AxisMode::kCircle && dot(axis_at(p), axis) < kOwnColumn;
}

std::optional<Point<Part>> Deformation::column_end(double x, double y) const {
  const double length = column_length({x, y, 0.0});
  if (!std::isfinite(length)) return std::nullopt;
  const AxisLine line = axis_line(x, y);
  return line.base + line.axis * length;
}

bool Deformation::in_column(Point<Flat> f, double margin) const {
  Angles angles;
  angles.cos_y = std::cos(f.y / scale_y_);
  return in_column(f.z, angles, margin);
}

double Deformation::period_x() const {
  const bool wraps = frame_.mode == AxisMode::kPoint || frame_.mode == AxisMode::kCircle;
  return wraps ? 2.0 * kPi * scale_x_ : 0.0;
}

double Deformation::period_y() const {
  const bool wraps = frame_.mode == AxisMode::kLine || frame_.mode == AxisMode::kCircle;
  return wraps ? 2.0 * kPi * scale_y_ : 0.0;
}

Point<Flat> Deformation::beside(Point<Flat> f, Point<Flat> place) const {
  return {short_way(place.x, f.x, period_x()), short_way(place.y, f.y, period_y()), f.z};
}

}  // namespace tiltfeed::pathgen
