#pragma once
// A cone about a mean direction that holds the normals of a piece of surface.

#include <array>
#include <vector>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::pathgen {

/// The unit vectors within an angle of `axis` (unit).
struct NormalCap {
  Vec3 axis{0, 0, 1};
  double cosine = -1.0, sine = 0.0;  ///< of the angle, up to 90 degrees; a cosine of -1: all there are

  /// Between which their dot products with the unit `direction` lie.
  std::array<double, 2> along(Vec3 direction) const;
};

/// The cap of this angle (rad, up to 78 degrees), widened by 1e-6 rad for rounding; wider ones hold all.
NormalCap cap_of(Vec3 axis, double angle);
/// About unit vectors and the cone that they span; it holds all where there are none.
NormalCap cap_about(const std::vector<Vec3>& normals);

}  // namespace tiltfeed::pathgen
