#pragma once
// Where the tool may stand over a feature of the part: the places of the CL reference over its corners, for
// each of its contact normals. (S4), (S5) in pathgen/surface/README.md.

#include <span>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/surface/cl_surface.h"

namespace tiltfeed::pathgen {

class ContactHull {
 public:
  ContactHull(const ClSurface& surface, const Deformation& map) : surface_(surface), map_(map) {}

  /// What the contact normals of a patch allow.
  enum class Reach {
    kNone,     ///< its feature is nowhere touched
    kBounded,  ///< place() bounds it
    kTip,      ///< they point all ways, and its facets' normals tell whether it faces away
    kAround    ///< they point all ways
  };
  Reach take(PatchId patch, int side);

  /// Requires: kBounded. The patch over this part of the feature lies in the hull of points(), widened by
  /// margin() (mm).
  void place(std::span<const Point<Part>> core);
  std::span<const Point<Part>> points() const { return points_; }
  double margin() const { return margin_; }

 private:
  bool gather_normals();
  void surround_normals();
  void place_on_rings(std::span<const Point<Part>> core);
  Point<Part> on_ring(Point<Part> q, Vec3 n, double d, double r);

  const ClSurface& surface_;
  const Deformation& map_;
  const ToolPiece* piece_ = nullptr;
  std::vector<Vec3> normals_;  ///< of the patch, their mean, and the cone about it that holds them
  double bulge_ = 0.0;         ///< how far contact normals bulge out of the hull of normals_, mm
  Vec3 mean_;
  double cone_cosine_ = 1.0, cone_sine_ = 0.0;
  std::vector<Point<Part>> points_;
  double margin_ = 0.0;
};

}  // namespace tiltfeed::pathgen
