#pragma once
// Containment by faces of the part: which poses of the tool machine them. (T5) in pathgen/tool/README.md.

#include "pathgen/mesh/facet_bvh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

class FaceContainment {
 public:
  /// Requires: options.only_faces, which must outlive it.
  explicit FaceContainment(const PlanOptions& options);

  /// Does the cutter's end, with the stock that is to stay, come within reach() of a chosen face? Its CL
  /// reference and unit axis; the end goes up to where its rounding is widest. Property: what a place of the
  /// faces has left by the ends of all poses, it has left by those alone of which this is true, if that is no
  /// more than reach(). Off by kNearlyNear (mm) at most, and then true. Any thread may ask.
  bool near(Point<Part> reference, Vec3 axis) const { return near(reference, axis, reach_); }
  /// The same of a cutter that ends in a ball, of the ball alone.
  bool near_ball(Point<Part> centre) const { return near_ball(centre, reach_); }
  /// The same for a way between two passes, which end where the tool ceases to be near: the tolerance more.
  bool near_on_way(Point<Part> reference, Vec3 axis) const { return near(reference, axis, reach_ + slack_); }
  bool near_ball_on_way(Point<Part> centre) const { return near_ball(centre, reach_ + slack_); }

  /// By so much may the cutter stay off a face, mm: as it does where it touches a plane `beyond` from the
  /// face's edge, and the tolerance.
  double reach() const { return reach_; }
  /// A pass that comes over a face is near to it along so much of its way, mm.
  double spacing() const { return spacing_; }

 private:
  bool near(Point<Part> reference, Vec3 axis, double reach) const;
  bool near_ball(Point<Part> centre, double reach) const;
  bool comes_near(const Corners& corners, Point<Part> ring, Vec3 axis, double reach) const;

  FacetBvh tree_;
  ToolPiece piece_;
  double reach_, spacing_, slack_;
};

inline constexpr double kNearlyNear = 1e-4;

}  // namespace tiltfeed::pathgen
