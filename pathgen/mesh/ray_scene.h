#pragma once
// Rays against a part, by Embree, in single precision.

#include <memory>

#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

class RayScene {
 public:
  /// Everything is moved so that `origin` is zero: single precision then suffices far from the part's own
  /// zero.
  explicit RayScene(Point<Part> origin);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// Every facet, moved by `offset` along its normal, mm.
  void add_triangles(const Mesh& mesh, double offset);
  /// Every edge once, as a rod of this radius (mm) with round ends.
  void add_edges(const Mesh& mesh, double radius);
  /// Call once, after the last add and before the first ray.
  void commit();

  /// Does the segment hit anything? Safe to call from several threads.
  bool hits(Point<Part> from, Vec3 direction, double length) const;

  /// Is a triangle within `distance` (mm) of p? Triangles only.
  bool within(Point<Part> p, double distance) const;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  Point<Part> origin_;
};

}  // namespace tiltfeed::pathgen
