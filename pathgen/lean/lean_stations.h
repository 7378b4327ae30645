#pragma once
// A pass by its length, with a frame that is carried along it: in this frame a lean is two numbers. (Y3) in
// pathgen/lean/README.md.

#include <cmath>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/envelope/pass.h"

namespace tiltfeed::pathgen {

/// By how much and where to the tool leans, rad: the angles in two directions square to the mode's axis.
struct LeanAngle {
  double u = 0.0, v = 0.0;
  bool operator==(const LeanAngle&) const = default;
  double size() const { return std::hypot(u, v); }
};
inline LeanAngle lerp(LeanAngle a, LeanAngle b, double f) {
  return {a.u + (b.u - a.u) * f, a.v + (b.v - a.v) * f};
}

/// A place of the pass.
struct LeanStation {
  EnvelopePoint point;     ///< with the mode's axis
  double run = 0.0;        ///< mm from the pass's start
  Vec3 first{}, second{};  ///< unit, square to the axis and to each other
  Vec3 before{}, ahead{};  ///< unit: which way the pass comes there and goes on; 0 at its ends
  bool given = false;      ///< a point of the pass

  /// The tool axis, unit; the mode's own, to the last bit, without a lean.
  Vec3 axis(LeanAngle lean) const;
  /// What axis() makes this of. Requires: unit, nearer than 180 degrees to the mode's axis.
  LeanAngle lean_of(Vec3 axis) const;
  /// The lean as a direction over a flat ground: two of them are as far apart as the tool axes.
  static Vec3 direction(LeanAngle lean);
};

class PassFrames {
 public:
  /// Both must outlive it. Requires: at least one point.
  PassFrames(const Pass& pass, const Deformation& map);

  double length() const { return points_.back().run; }
  const std::vector<LeanStation>& points() const { return points_; }
  LeanStation at(double run) const;
  /// At `from` and `to`, at the points of the pass between them, and between all these no further apart than
  /// `spacing`, mm.
  std::vector<LeanStation> between(double from, double to, double spacing) const;

 private:
  const Deformation& map_;
  std::vector<LeanStation> points_;
};

}  // namespace tiltfeed::pathgen
