#pragma once
// A convex solid of revolution, and its exact distance and drop against points, straight lines, triangles and
// boxes. Its outline lies in the half-plane (r, h): r >= 0 from the axis, h along the axis above the tool
// tip. Formulas (V5)..(V7) are in sim/path_check/README.md. Every least value over a line is found by convex
// search, so no closed form is shared with the planner.

#include <array>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "sim/solid/triangle.h"

namespace tiltfeed::sim {

/// Least values over lines are found to within this, mm.
inline constexpr double kSearchError = 1e-10;

/// A corner of the outline, from the lower end of the axis to the upper: an arc of `radius` (0: sharp) about
/// (r, h). Outward normals (sin psi, -cos psi) turn from the angle of the corner before (0: straight down) to
/// `turn`, rad; the last corner turns to pi.
struct Corner {
  double r = 0.0, h = 0.0, radius = 0.0, turn = 0.0;
};

/// A convex function's value and one of its slopes along r and h.
struct Slope {
  double value = 0.0, along_r = 0.0, along_h = 0.0;
};

class Revolved {
 public:
  /// Requires: at least one corner, convex, in order, turns ascending to pi.
  explicit Revolved(const std::vector<Corner>& corners);
  /// From sharp points in order; the first and last are the rims of the lower and upper face.
  static Revolved from_rims(const std::vector<std::array<double, 2>>& rims);

  /// The Minkowski sum with a ball of radius `allowance` and a cylinder from -axial to 0 of radius `radial`.
  Revolved grown(double allowance, double radial, double axial) const;

  /// (V5) Signed distance of the point (r, h): negative inside, there the depth to the nearest of the border.
  Slope distance(double r, double h) const;
  /// (V6) Height of the lower border at r; infinite beyond the widest.
  Slope lower_border(double r) const;

  double widest() const { return widest_; }
  /// The lowest height at which it is widest.
  double widest_height() const { return widest_height_; }
  double radius_at(double h) const;  ///< of its section at h; negative: none
  const std::vector<Corner>& corners() const { return corners_; }

 private:
  struct Side {
    double sine, cosine;  ///< of the angle of the normal between a corner and the next
  };
  std::vector<Corner> corners_;
  std::vector<Side> sides_;  ///< sides_[i] follows corner i
  double widest_ = 0.0, widest_height_ = 0.0;
};

/// A solid standing at a pose.
class Standing {
 public:
  Standing(const Revolved& solid, const Pose& pose) : solid_(&solid), tip_(pose.tip), axis_(pose.axis) {}

  /// Lower bounds over a box; exact where the box is a point.
  double distance_bound(Vec3 low, Vec3 high) const;
  double drop_bound(Vec3 low, Vec3 high) const;
  /// (V5) Least signed distance of the triangle (edges not owned left out), if below `bound`; else `bound`.
  double distance(const Triangle& triangle, double bound) const;
  /// (V6) How far it moves along -axis until its lower border touches the triangle, if below `bound`; 0 where
  /// it does from the start. What lies above the widest place is not touched.
  double drop(const Triangle& triangle, double bound) const;

 private:
  struct At {
    double r, h;
    Vec3 out;  ///< unit, away from the axis; zero on it
  };
  At at(Vec3 from_tip) const;
  double least_distance(Vec3 from, Vec3 to, double bound) const;
  double least_drop(Vec3 from, Vec3 to, double bound) const;

  const Revolved* solid_;
  Point<Part> tip_;
  Vec3 axis_;
};

}  // namespace tiltfeed::sim
