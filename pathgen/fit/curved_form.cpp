#include "pathgen/fit/curved_form.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// Less than this is a radius no shape has, in units of the points' spread.
constexpr double kLeastRadius = 1e-9;

Vec3 square_to(Vec3 v, Vec3 axis) { return v - axis * dot(v, axis); }

/// Any unit vector square to a unit one.
Vec3 any_square_to(Vec3 axis) {
  const double x = std::abs(axis.x), y = std::abs(axis.y), z = std::abs(axis.z);
  const Vec3 pick = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  return normalized(square_to(pick, axis));
}

double root(double of) { return std::sqrt(std::max(of, 0.0)); }

/// The same from f = k |v|^2 - 2 v.n.
double curved(double f, double k) { return f / (1.0 + root(1.0 + k * f)); }

double curvature(double radius) { return 1.0 / std::max(radius, kLeastRadius); }

}  // namespace

double curved_distance(Vec3 v, Vec3 n, double k) {
  return curved(k * squared_length(v) - 2.0 * dot(v, n), k);
}

CurvedForm::CurvedForm(FitKind kind, const Shape& first, Vec3 place) : kind_(kind) {
  axis_ = kind == FitKind::kSphere ? Vec3{0, 0, 1} : first.axis;
  const Vec3 from = place - first.centre;
  const Vec3 flat = kind == FitKind::kSphere ? from : square_to(from, axis_);
  const Vec3 away = length(flat) > kLeastRadius ? normalized(flat) : any_square_to(axis_);
  switch (kind) {
    case FitKind::kPlane:
      out_ = any_square_to(axis_), place_ = first.centre, start_.assign(3, 0.0);
      break;
    case FitKind::kSphere:
      out_ = -away, axis_ = any_square_to(out_);
      place_ = first.centre + away * first.radius, start_ = {0.0, 0.0, 0.0, curvature(first.radius)};
      break;
    case FitKind::kCircle:
      out_ = -away, place_ = first.centre + away * first.radius;
      start_ = {0.0, 0.0, 0.0, 0.0, 0.0, curvature(first.radius)};
      break;
    case FitKind::kCylinder:
      out_ = -away, place_ = first.centre + away * first.radius + axis_ * dot(from, axis_);
      start_ = {0.0, 0.0, 0.0, 0.0, curvature(first.radius)};
      break;
    case FitKind::kTorus: {
      out_ = away;
      const Vec3 ring = first.centre + away * first.radius;
      const Vec3 in_section = out_ * dot(place - ring, out_) + axis_ * dot(place - ring, axis_);
      const Vec3 to = length(in_section) > kLeastRadius ? normalized(in_section) : out_;
      place_ = ring + to * first.tube;
      const double from_axis = dot(place_ - first.centre, out_);
      start_ = {0.0,
                0.0,
                0.0,
                0.0,
                std::atan2(-dot(to, axis_), -dot(to, out_)),
                curvature(first.tube),
                1.0 / (std::abs(from_axis) > kLeastRadius ? from_axis : kLeastRadius)};
      break;
    }
  }
  side_ = cross(axis_, out_);
}

CurvedForm::Frame CurvedForm::frame(std::span<const double> p) const {
  if (kind_ == FitKind::kSphere)
    return {place_ + out_ * p[0], normalized(out_ + side_ * p[1] + axis_ * p[2]), side_, axis_};
  if (kind_ == FitKind::kPlane)
    return {place_ + axis_ * p[0], out_, side_, normalized(axis_ + out_ * p[1] + side_ * p[2])};
  const Vec3 axis = normalized(axis_ + out_ * p[1] + side_ * p[2]);
  const Vec3 out = normalized(square_to(out_ + side_ * p[3], axis));
  const Vec3 lift = kind_ == FitKind::kCircle ? axis_ * p[4] : Vec3{};
  return {place_ + out_ * p[0] + lift, out, cross(axis, out), axis};
}

void CurvedForm::residuals(std::span<const double> p, Vec3 point, std::span<double> to) const {
  const Frame f = frame(p);
  const Vec3 v = point - f.place;
  const double along = dot(v, f.axis);
  switch (kind_) {
    case FitKind::kPlane:
      to[0] = along;
      return;
    case FitKind::kSphere:
      to[0] = curved_distance(v, f.out, p[3]);
      return;
    case FitKind::kCircle:
      to[0] = curved_distance(v - f.axis * along, f.out, p[5]), to[1] = along;
      return;
    case FitKind::kCylinder:
      to[0] = curved_distance(v - f.axis * along, f.out, p[4]);
      return;
    case FitKind::kTorus: {
      const double radial = curved_distance(v - f.axis * along, -f.out, p[6]);
      const double in = radial * std::cos(p[4]) + along * std::sin(p[4]);
      to[0] = curved(p[5] * (radial * radial + along * along) - 2.0 * in, p[5]);
    }
  }
}

Shape CurvedForm::shape(std::span<const double> p) const {
  const Frame f = frame(p);
  switch (kind_) {
    case FitKind::kPlane:
      return {f.place, f.axis, 0.0, 0.0};
    case FitKind::kSphere:
      return {f.place + f.out / p[3], f.axis, 1.0 / std::abs(p[3]), 0.0};
    case FitKind::kCircle:
      return {f.place + f.out / p[5], f.axis, 1.0 / std::abs(p[5]), 0.0};
    case FitKind::kCylinder: {
      const Vec3 on_axis = f.place + f.out / p[4];
      return {square_to(on_axis, f.axis), f.axis, 1.0 / std::abs(p[4]), 0.0};
    }
    case FitKind::kTorus:
      break;
  }
  const double tube = 1.0 / p[5];
  return {f.place - f.out / p[6] + f.axis * (tube * std::sin(p[4])), f.axis,
          std::abs(1.0 / p[6] + tube * std::cos(p[4])), std::abs(tube)};
}

}  // namespace tiltfeed::pathgen
