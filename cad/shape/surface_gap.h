#pragma once
// How far a place is from a face's surface.

#include <memory>
#include <string>

#include "kinematics/basics/geometry.h"

class TopoDS_Face;

namespace tiltfeed::cad {

/// The surface of a face without its borders. `face` must not outlive its shape.
class SurfaceGap {
 public:
  explicit SurfaceGap(const TopoDS_Face& face);
  ~SurfaceGap();
  SurfaceGap(const SurfaceGap&) = delete;
  SurfaceGap& operator=(const SurfaceGap&) = delete;

  /// Distance, mm: in closed form of planes, cylinders, cones, spheres and tori. Of others the least that a
  /// search from (u, v) comes to: never less than the true one.
  double operator()(Point<Part> p, double u, double v) const;
  /// Of the surface at (u, v), unit, along dS/du x dS/dv; zero where it has none.
  Vec3 normal(double u, double v) const;
  /// "cylinder", "spline" ...
  std::string kind() const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace tiltfeed::cad
