#pragma once
// What a piece of the tool passes through while it is pushed along a straight way: a convex body, and where a
// line runs inside it. Formulas (W1)..(W3) are in sim/removal/README.md.

#include <algorithm>
#include <array>
#include <optional>

#include "sim/solid/revolved.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed::sim {

/// Either round: all points within `radius` of the parallelogram foot + a along + b way (a, b in 0..1), which
/// is a ball or a piece of a shank; or `solid`, which stands at `foot` with `along` as its unit axis.
struct SweptBody {
  Point<Part> foot;
  Vec3 along, way;
  double radius = 0.0;              ///< round: mm
  const Revolved* solid = nullptr;  ///< not owned
  ToolPart part = ToolPart::kCutter;
  Vec3 low, high;           ///< bounds
  bool above_ball = false;  ///< made by without_ball()

  static SweptBody round(Point<Part> foot, Vec3 along, Vec3 way, double radius, ToolPart part);
  static SweptBody revolved(const Revolved& solid, const Pose& pose, Vec3 way, ToolPart part);

  /// A round body of which the ball at `foot` with its way is cut by itself: what is only in that may be left
  /// out, and is not within low and high.
  SweptBody without_ball() const;

  /// Of without_ball(): is p below the plane through the ball's centre, all along the way?
  bool leaves_to_ball(Point<Part> p) const {
    return above_ball && dot(p - foot, along) < std::min(0.0, dot(way, along));
  }

  /// How deep p is inside, mm; negative outside.
  double depth(Point<Part> p) const;
};

/// Where a line is inside a body, mm along the line.
struct Inside {
  double enter = 0.0, leave = 0.0;
};

/// Lines of one direction against one body.
class LineCutter {
 public:
  /// Requires: `direction` unit; `body` outlives this.
  LineCutter(const SweptBody& body, Vec3 direction);

  /// Where the line from `origin` is inside, or nothing. `low`, `high`: the stretch of it that matters; what
  /// lies beyond may be left out, and a line that is inside only there be told as nothing.
  std::optional<Inside> operator()(Point<Part> origin, double low, double high) const;

 private:
  /// (W1) A line through a capsule.
  struct Capsule {
    Vec3 foot, unit;
    double whole = 0.0;
    double along = 0.0;    ///< of the line's direction and the axis
    double square = 0.0;   ///< of the line's direction less its part along the axis
    double inverse = 0.0;  ///< of square; 0: the line runs along the axis
    /// From the nearest point of its axis to p.
    Vec3 off(Vec3 p) const {
      const Vec3 w = p - foot;
      return w - unit * std::clamp(dot(w, unit), 0.0, whole);
    }
  };
  /// low <= gradient . p <= high; inverse of gradient . direction, 0: no change along the line.
  struct Slab {
    Vec3 gradient;
    double low = 0.0, high = 0.0, inverse = 0.0;
  };
  Capsule capsule(Point<Part> from, Vec3 along) const;
  Slab slab(Vec3 gradient, double low, double high) const;
  double border(const Capsule& c, Vec3 origin, double sign) const;
  Inside between(Vec3 origin) const;
  std::optional<Inside> through_solid(Point<Part> origin, double low, double high) const;

  const SweptBody& body_;
  Vec3 direction_;
  double r2_;
  std::array<Capsule, 4> capsules_;
  int count_ = 0;
  std::array<Slab, 3> slabs_;  ///< of the parallelogram, if there are more capsules than one
  Vec3 above_;                 ///< above_ball: (W7) what is below above_ . p = above_from_ is the ball's
  double above_from_ = -kInfinity, above_slope_ = 0.0;
  Vec3 side_;  ///< unit, across line and `along`: lines are told apart by it
  double side_low_ = -kInfinity, side_high_ = kInfinity;  ///< of what the body covers of it
};

}  // namespace tiltfeed::sim
