#pragma once
// Cones of contact normals, as convex spherical polygons. (S4) in pathgen/surface/README.md.

#include <span>
#include <vector>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::pathgen {

inline constexpr std::size_t kMostSpokes = 24;

/// Cuts the cone of the unit vectors `normals` down to what lies behind every one of `spokes`: n.e <= slack
/// |e| for each of them, with a little to spare. What is left is the cone of the new `normals`; their number
/// may differ. Cones wider than 60 degrees to their mean stay as they are, and so they do for more than
/// kMostSpokes. False if nothing is left.
bool cut_cone(std::vector<Vec3>& normals, std::span<const Vec3> spokes, double slack);

/// A cone of unit vectors that is nearly an arc: within `aside` (rad) of the great circle from `from` to
/// `to`.
struct NormalArc {
  Vec3 from, to;
  double aside = 0.0;
};
/// The arc between the two that are furthest apart. Requires: at least one vector, all within 60 degrees of
/// their mean.
NormalArc widest_arc(std::span<const Vec3> normals);

/// The point in which the tangents meet that touch the unit sphere at the arc's ends, in the arc's plane: arc
/// and ends lie in the triangle of the three.
Vec3 arc_apex(const NormalArc& arc);

}  // namespace tiltfeed::pathgen
