#pragma once
// What a segment covers while it is pushed along: a parallelogram, and how far things are from it.

#include <algorithm>
#include <cmath>

#include "kinematics/geometry.h"

namespace tiltfeed::sim {

/// All points foot + a way + b along, a and b in 0..1; both may be zero or parallel.
class Sheet {
 public:
  Sheet(Point<Part> foot, Vec3 way, Vec3 along)
      : foot_(foot), way_(way), along_(along), ww_(dot(way, way)), wa_(dot(way, along)), aa_(dot(along, along)) {
    const double det = ww_ * aa_ - wa_ * wa_;
    inverse_ = det > kFlat * ww_ * aa_ ? 1.0 / det : 0.0;
  }

  /// From the nearest point of the sheet to p.
  Vec3 to(Point<Part> p) const {
    const Vec3 m = p - foot_;
    const double mw = dot(m, way_), ma = dot(m, along_);
    if (inverse_ > 0.0) {
      const double a = (aa_ * mw - wa_ * ma) * inverse_, b = (ww_ * ma - wa_ * mw) * inverse_;
      if (a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0) return m - way_ * a - along_ * b;
    }
    // On one of the four sides.
    const auto part = [](double along, double whole) {
      return whole > 0.0 ? std::clamp(along / whole, 0.0, 1.0) : 0.0;
    };
    Vec3 best = m - way_ * part(mw, ww_);
    for (const Vec3 other : {m - along_ * part(ma, aa_), m - way_ - along_ * part(ma - wa_, aa_),
                             m - along_ - way_ * part(mw - wa_, ww_)})
      if (squared_length(other) < squared_length(best)) best = other;
    return best;
  }
  /// The point of the way (b = 0) nearest to p.
  Point<Part> on_way(Point<Part> p) const {
    return foot_ + way_ * (ww_ > 0.0 ? std::clamp(dot(p - foot_, way_) / ww_, 0.0, 1.0) : 0.0);
  }
  /// Not more than the distance from the box: the sheet is convex, so it lies behind the plane through its point
  /// nearest to the box's middle, square to the way there.
  double bound(Vec3 low, Vec3 high) const {
    const Vec3 half = (high - low) * 0.5, u = to(Point<Part>{} + (low + high) * 0.5);
    const double far2 = squared_length(u);
    if (far2 <= 0.0) return 0.0;
    return (far2 - std::abs(u.x) * half.x - std::abs(u.y) * half.y - std::abs(u.z) * half.z) / std::sqrt(far2);
  }

 private:
  // Below this squared sine of their angle the sheet is taken as its four sides: they cover it to less than
  // 1e-6 of its length.
  static constexpr double kFlat = 1e-12;
  Point<Part> foot_;
  Vec3 way_, along_;
  double ww_, wa_, aa_, inverse_;
};

}  // namespace tiltfeed::sim
