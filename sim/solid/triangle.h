#pragma once
// One triangle against a point, the tool's axis (a segment) and a moving ball, in closed form.
// Formulas (V1)..(V3) are in sim/path_check/README.md. Shares nothing with pathgen's CL surface.

#include <cstdint>
#include <limits>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::sim {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A straight piece of the tool's axis, or any other.
struct Segment {
  Point<Part> from, to;
};

/// A facet made ready for distances. Edges and corners that several facets share are owned by the first of
/// them, so that each is looked at once; `owned` has bits 0..2 for the edges ab, bc, ca and 3..5 for a, b, c.
struct Triangle {
  Point<Part> a;
  Vec3 ab, ac;
  Vec3 normal;          ///< unit; zero for a facet without area, which then counts by its edges only
  Vec3 grad_v, grad_w;  ///< of the barycentric coordinates: v(x) = grad_v . (x - a), 0 along ac
  std::uint32_t facet = 0;
  std::uint8_t owned = 0x3F;
};

Triangle make_triangle(Point<Part> a, Point<Part> b, Point<Part> c, std::uint32_t facet);

/// (V1) Squared distance from p to the closed triangle, edges not owned left out.
double squared_distance(const Triangle& triangle, Point<Part> p);
/// (V2) Squared distance from the closed segment to the closed triangle, 0 when it pierces it; edges not
/// owned left out.
double squared_distance(const Triangle& triangle, const Segment& segment);
/// Squared distance of two closed segments.
double squared_distance(const Segment& a, const Segment& b);

/// (V3) The smallest s >= 0 at which a ball with its centre at `centre + s direction` touches the triangle:
/// its plane, its owned edges (cylinders) and corners (spheres). `bound` when that is not below `bound`.
/// Requires: direction unit.
double first_touch(const Triangle& triangle, Point<Part> centre, Vec3 direction, double radius, double bound);

/// Solid angle of the triangle seen from p, sr, positive from behind (inside) [Van Oosterom, Strackee 1983].
double solid_angle(const Triangle& triangle, Point<Part> p);

}  // namespace tiltfeed::sim
