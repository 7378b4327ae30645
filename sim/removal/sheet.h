#pragma once
// What a segment covers while it is pushed along: a parallelogram, and how far things are from it.

#include <algorithm>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::sim {

/// All points foot + a way + b along, a and b in 0..1; both may be zero or parallel.
class Sheet {
 public:
  Sheet(Point<Part> foot, Vec3 way, Vec3 along)
      : foot_(foot),
        way_(way),
        along_(along),
        ww_(dot(way, way)),
        wa_(dot(way, along)),
        aa_(dot(along, along)) {
    const double det = ww_ * aa_ - wa_ * wa_;
    inverse_ = det > kFlat * ww_ * aa_ ? 1.0 / det : 0.0;
    per_ww_ = ww_ > 0.0 ? 1.0 / ww_ : 0.0, per_aa_ = aa_ > 0.0 ? 1.0 / aa_ : 0.0;
  }

  /// From the nearest point of the sheet to p.
  Vec3 to(Point<Part> p) const {
    const Vec3 m = p - foot_;
    const double mw = dot(m, way_), ma = dot(m, along_);
    const auto part = [](double value) { return std::clamp(value, 0.0, 1.0); };
    const auto beside_way = [&](double b) { return m - along_ * b - way_ * part((mw - b * wa_) * per_ww_); };
    const auto beside_along = [&](double a) {
      return m - way_ * a - along_ * part((ma - a * wa_) * per_aa_);
    };
    const auto nearer = [](Vec3 a, Vec3 b) { return squared_length(a) < squared_length(b) ? a : b; };
    if (inverse_ == 0.0)
      return nearer(nearer(beside_way(0.0), beside_way(1.0)), nearer(beside_along(0.0), beside_along(1.0)));
    const double a = (aa_ * mw - wa_ * ma) * inverse_, b = (ww_ * ma - wa_ * mw) * inverse_;
    const bool off_a = a < 0.0 || a > 1.0, off_b = b < 0.0 || b > 1.0;
    if (!off_a && !off_b) return m - way_ * a - along_ * b;
    // From outside, the nearest side is one of those that p lies beyond.
    if (!off_a) return beside_way(b < 0.0 ? 0.0 : 1.0);
    if (!off_b) return beside_along(a < 0.0 ? 0.0 : 1.0);
    return nearer(beside_way(b < 0.0 ? 0.0 : 1.0), beside_along(a < 0.0 ? 0.0 : 1.0));
  }
  /// The point of the way (b = 0) nearest to p.
  Point<Part> on_way(Point<Part> p) const {
    return foot_ + way_ * std::clamp(dot(p - foot_, way_) * per_ww_, 0.0, 1.0);
  }

 private:
  // Below this squared sine of their angle the sheet is taken as its four sides: they cover it to less than
  // 1e-6 of its length.
  static constexpr double kFlat = 1e-12;
  Point<Part> foot_;
  Vec3 way_, along_;
  double ww_, wa_, aa_, inverse_, per_ww_, per_aa_;
};

}  // namespace tiltfeed::sim
