#pragma once
// The blank: what the first operation cuts the part from.

#include <memory>
#include <vector>

#include "pathgen/mesh/facet_bvh.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

class BlankSolid {
 public:
  /// Along the part's axes.
  static BlankSolid box(const Box& box);
  /// Round bar: from `base` along `axis` (unit) over `height`, mm.
  static BlankSolid bar(Point<Part> base, Vec3 axis, double radius, double height);
  /// Requires: closed, facets turned outwards.
  static BlankSolid closed(Mesh mesh);

  /// Is the place in it, or within `margin` (mm) of it? Any thread may ask.
  bool holds(Point<Part> place, double margin) const;
  /// Its surface; sides of a bar stand out of it by kStandOut (mm) at most.
  const Mesh& mesh() const { return mesh_; }
  const Box& bounds() const { return bounds_; }
  /// Places all over its surface, neighbours at most `apart` (mm) from each other.
  std::vector<Point<Part>> places(double apart) const;

  static constexpr double kStandOut = 0.02;

 private:
  enum class Kind { kBox, kBar, kMesh };
  BlankSolid(Kind kind, Mesh mesh);
  bool inside_mesh(Point<Part> place) const;

  Kind kind_;
  Mesh mesh_;
  Box bounds_;
  Point<Part> base_;
  Vec3 axis_{0, 0, 1};
  double radius_ = 0.0, height_ = 0.0;
  std::shared_ptr<const FacetBvh> tree_;  ///< of a mesh
};

}  // namespace tiltfeed::pathgen
