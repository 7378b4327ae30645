#pragma once
// The exact drop of one piece of the tool along its axis line: the highest place at which it touches a
// vertex, an edge or a facet. Closed forms but for a rounded edge against an edge of the part, which is the
// root of a monotone function. (C1)..(C4) in pathgen/surface/README.md.

#include <limits>

#include "pathgen/axis/deformation.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

/// A place of the CL reference on an axis line where the tool touches.
struct ClHit {
  double z = 0.0;  ///< z' along the line, mm
  Vec3 normal;     ///< unit, of the part at the contact, towards the tool
  Vec3 twist;      ///< mm; how the turning of the axis tilts the CL surface: (C5)
};

/// (C4) Slack of the patch borders: an angle (rad) on the ball, and as a share of the radius a length. Wide
/// enough to close the seams that rounding and skipped nearly flat edges leave; it raises the surface of a
/// ball by R kSeam^2 / 8, less than 1e-9 mm.
inline constexpr double kSeam = 2e-5;
/// (C4) Below this sine against the axis a facet or edge is level: the flat bottom lies on it. The height is
/// out by the tool's radius times this at most.
inline constexpr double kLevel = 1e-6;
/// A facet or edge steeper than this against the axis (cosine, squared sine) has no height of its own.
inline constexpr double kSteepest = 1e-9;

/// No height is asked for.
inline constexpr double kAnyHeight = -std::numeric_limits<double>::infinity();

/// Each returns false where there is no contact within the feature, its border widened by `slack` (mm), or
/// none of z' at least `least`: that it is lower is seen early.
bool drop_on_vertex(const ToolPiece& piece, const Point<Part>& v, const AxisLine& line, ClHit& hit,
                    double least = kAnyHeight);
bool drop_on_edge(const ToolPiece& piece, const Point<Part>& p, const Point<Part>& q, double slack,
                  const AxisLine& line, ClHit& hit, double least = kAnyHeight);
/// `n`: unit normal of the facet on the tool's side, from where the corners are counter-clockwise.
bool drop_on_facet(const ToolPiece& piece, const Point<Part>& a, const Point<Part>& b, const Point<Part>& c,
                   const Vec3& n, double slack, const AxisLine& line, ClHit& hit, double least = kAnyHeight);

}  // namespace tiltfeed::pathgen
