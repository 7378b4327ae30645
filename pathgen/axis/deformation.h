#pragma once
// The predefined tool axis and the deformation that turns it into +z' everywhere (maths:
// pathgen/axis/README.md, tags D1..D4). Right-handed: (x', y', z') with b = s (n x t).

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::pathgen {

enum class AxisMode {
  kFixed,   ///< along n everywhere: the 3-axis case, the identity map
  kPoint,   ///< through the point O
  kLine,    ///< through and perpendicular to the line O + x t
  kCircle,  ///< through and perpendicular to the circle (O, radius, plane of t and n)
  kFree,    ///< not predefined: chosen clear of the part at every point (pathgen/plan/free_plan.h); no
            ///< deformation
  kIndexed  ///< one of a few fixed directions, each for what it reaches (pathgen/plan/indexed.h); no
            ///< deformation
};

/// The image of `target` nearest to `from`, where the coordinate has that period (0: none).
inline double short_way(double from, double target, double period) {
  return period > 0.0 ? target + period * std::round((from - target) / period) : target;
}

/// Where the shank points: away from the point/line/circle (outside work) or towards it (inside work).
enum class Sense : int { kOutward = +1, kInward = -1 };

/// t, n unit and perpendicular. Theta is measured from n towards t (point, circle) or towards b (line).
struct AxisFrame {
  AxisMode mode = AxisMode::kFixed;
  Sense sense = Sense::kOutward;
  Point<Part> origin;
  Vec3 t{1, 0, 0}, n{0, 0, 1};
  double circle_radius = 0.0;  ///< R_i, mm; circle mode only
  double circle_radius_or_zero() const { return mode == AxisMode::kCircle ? circle_radius : 0.0; }
};

/// The flat coordinate along which a pass runs; passes lie side by side in the other one.
enum class Along { kX, kY };

/// The line of points that share (x', y'): base + z' * axis. `axis` is the tool axis, from tip to shank.
struct AxisLine {
  Point<Part> base;
  Vec3 axis;
};

/// Properties, away from the point, line or circle, the axis of Theta and the seam: 1 unflatten() undoes
/// flatten(), and the other way round: within 1e-10 mm. 2 The map is right-handed. 3 A unit step of z' is a
/// unit step along axis_at(), and steps of x' and y' are square to it. 4 axis_at() points away from the
/// point, line or circle, or towards it, as the sense says: within 1e-12. 5 The image of a place within
/// `radius` of p is no further from that by tangent(p) than bend() says.
class Deformation {
 public:
  /// `scale_radius`: R of the maths, mm: the mean rho of the CL surface; sets the scale of x' and y' only.
  /// Requires: frame.mode is not kFree.
  Deformation(const AxisFrame& frame, double scale_radius);

  Point<Flat> flatten(Point<Part> p) const;
  /// How far p is from the point, line or circle (rho) and from the axis of Theta (r), mm; infinite where the
  /// mode has none.
  struct Distances {
    double rho, r;
  };
  Distances distances(Point<Part> p) const;
  /// The same with the tool axis there (as axis_at()), for less than the two apart; where rho or r is 0, no
  /// direction is to be trusted.
  struct Aim {
    Distances away;
    Vec3 axis;
  };
  Aim aim(Point<Part> p) const;
  /// The map about p to first order: dx' = x.dp, dy' = y.dp, dz' = aim.axis.dp.
  struct Tangent {
    Aim aim;
    Vec3 x, y;
  };
  Tangent tangent(Point<Part> p) const;
  /// How far off that the images of places may be whose steps from p bend, see bending(), by no more than
  /// `radius`, mm (S2); `least`: distances that none of them falls below.
  struct Bend {
    double x, y, z;
  };
  Bend bend(Distances least, double radius) const;
  /// Where p is at such distances the axis turns by at most a radian in this length, mm: it points at the
  /// feature, and from a circle it also turns with Theta.
  double turning_length(Distances d) const {
    return frame_.mode == AxisMode::kCircle ? std::min(d.rho, d.r) : d.rho;
  }
  /// What of a step d turns the axis and bends the map: all of it, but along a line nothing changes.
  Vec3 bending(Vec3 d) const { return frame_.mode == AxisMode::kLine ? d - frame_.t * dot(d, frame_.t) : d; }
  /// z' of p.
  double height(Point<Part> p) const {
    return frame_.mode == AxisMode::kFixed ? dot(p - frame_.origin, frame_.n) : s_ * distances(p).rho;
  }
  Point<Part> unflatten(Point<Flat> f) const;
  AxisLine axis_line(double x, double y) const {
    Angles angles;
    return axis_line(x, y, angles);
  }
  /// The sines and cosines of the last axis line, kept for the next one, which often shares a coordinate.
  struct Angles {
    double x = std::numeric_limits<double>::quiet_NaN(), sin_x = 0.0, cos_x = 1.0;
    double y = std::numeric_limits<double>::quiet_NaN(), sin_y = 0.0, cos_y = 1.0;
  };
  AxisLine axis_line(double x, double y, Angles& angles) const;
  /// Tool axis at p (unit, from tip to shank).
  Vec3 axis_at(Point<Part> p) const;
  /// What a unit step of x' and of y' is in part space at f, mm.
  struct Steps {
    Vec3 x, y;
  };
  Steps steps(Point<Flat> f) const;
  /// The most that these steps are at places up to `rho` (mm) from the point, line or circle, mm.
  struct Stretch {
    double x, y;
  };
  Stretch stretch(double rho) const;
  /// How fast the tool axis turns when f moves along v: its derivative, 1/mm for a unit v (C5).
  Vec3 axis_turn(Point<Flat> f, Vec3 v) const;
  /// How far the axis line of f runs on from f before it leaves its own flat column: to the point, line or
  /// circle in inside work; to the axis of Theta from the inner half of a circle in outside work; else
  /// infinite.
  double column_length(Point<Flat> f) const;
  /// Has a tool with its reference at p and this axis (unit) run on into another column, past the axis of
  /// Theta? Only from a circle can it.
  bool is_astray(Point<Part> p, Vec3 axis) const;
  /// The place where the column (x, y) ends, if it does.
  std::optional<Point<Part>> column_end(double x, double y) const;
  /// Is f at least `margin` (mm) inside its own column: away from the point, line or circle on its own side
  /// of it, and (circle) on its own side of the axis of Theta?
  bool in_column(Point<Flat> f, double margin) const;
  /// The same for the height z' on the axis line that `angles` was last used for.
  bool in_column(double z, const Angles& angles, double margin) const {
    if (frame_.mode == AxisMode::kFixed) return true;
    const double rho = z * s_;
    if (rho < margin) return false;
    return frame_.mode != AxisMode::kCircle || frame_.circle_radius + rho * angles.cos_y >= margin;
  }
  /// Length of the period of x' or y' (360 degrees), or 0 where that coordinate does not wrap.
  double period_x() const;
  double period_y() const;
  /// The image of f, whole periods off, that is nearest to `place` in x' and y'.
  Point<Flat> beside(Point<Flat> f, Point<Flat> place) const;

  const AxisFrame& frame() const { return frame_; }
  /// s: +1 where z' = rho (outside work and the fixed axis), -1 where z' = -rho (inside work).
  double s() const { return s_; }
  Vec3 b() const { return b_; }
  /// mm of x', y' per radian; 1 where the coordinate is a length.
  double scale_x() const { return scale_x_; }
  double scale_y() const { return scale_y_; }

 private:
  struct Section;
  Section section(Point<Part> p) const;

  AxisFrame frame_;
  Vec3 b_;
  double s_;
  double scale_x_, scale_y_;  ///< mm of x', y' per radian (1 where the coordinate is a length)
};

}  // namespace tiltfeed::pathgen
