#pragma once
// Shapes by curvature: a place on the surface, directions, and curvatures that may be zero. So a shape of any
// radius, a plane too, is described by numbers of the order of 1. (H1) in pathgen/fit/README.md.

#include <span>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "pathgen/fit/fitted_shape.h"

namespace tiltfeed::pathgen {

/// A shape in coordinates in which the points lie about zero, some 1 apart.
struct Shape {
  Vec3 centre;  ///< as Fit::centre
  Vec3 axis{0, 0, 1};
  double radius = 0.0, tube = 0.0;
};

/// A family of shapes about a first one: its parameters are zero there, but for the curvatures.
class CurvedForm {
 public:
  /// `place` on the first shape, or near it; there the family is as far from singular as can be.
  CurvedForm(FitKind kind, const Shape& first, Vec3 place);

  const std::vector<double>& start() const { return start_; }
  /// Residuals of a point: distances, two of a circle (in its plane and off it), else one.
  std::size_t residuals_each() const { return kind_ == FitKind::kCircle ? 2 : 1; }
  void residuals(std::span<const double> parameters, Vec3 point, std::span<double> out) const;
  Shape shape(std::span<const double> parameters) const;

 private:
  struct Frame {
    Vec3 place, out, side, axis;
  };
  Frame frame(std::span<const double> p) const;

  FitKind kind_;
  Vec3 place_, out_, side_, axis_;  ///< right-handed: out, side, axis; out points to the centre of curvature,
                                    ///< of a torus away from its axis
  std::vector<double> start_;
};

/// The distance of a place with the offset v from a place of a circle (or sphere) whose centre is 1 / k from
/// there along the unit direction n, taken as negative inside; exact for any k. (H1)
double curved_distance(Vec3 v, Vec3 n, double k);

}  // namespace tiltfeed::pathgen
