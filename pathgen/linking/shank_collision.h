#pragma once
// Whether a straight piece of the tool's shank is clear of the part: a line against the CL surface
// [Kim05, section 2], by rays.

#include <memory>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/ray_scene.h"

namespace tiltfeed::pathgen {

class ShankCollision {
 public:
  /// `radius`: of the tool there, stock left included, mm. `mesh` must outlive the object.
  ShankCollision(const Mesh& mesh, double radius);

  /// True if a shank round the segment from `from` along unit `direction` cuts into the part by more than
  /// ray_margin(). The segment starts in free air. Safe to call from several threads.
  bool blocked(Point<Part> from, Vec3 direction, double length) const {
    return scene_.hits(from, direction, length);
  }

  /// True if p is within the radius of the part's surface. Not safe to call from several threads.
  bool touches(Point<Part> p);

 private:
  const Mesh& mesh_;
  double radius_;
  RayScene scene_;                  ///< the part grown by the radius
  std::unique_ptr<RayScene> part_;  ///< as it is; made when first needed
};

/// Rays are single precision: they are shot at a surface this much (mm) inside the true one, far more than
/// their error, so that what they hit is truly hit. 64 roundings of the longest way along the mesh's box,
/// 2e-3 at most: parts of up to 10 m have been tried with that.
double ray_margin(const Mesh& mesh);

}  // namespace tiltfeed::pathgen
