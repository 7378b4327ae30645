#include "pathgen/tool/face_containment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

namespace {

/// Pieces of a triangle that wait; each bisection leaves one more.
constexpr std::size_t kMostWaiting = 64;

/// How far a place is over the tool's surface, and which way it comes away the fastest: a subgradient of
/// length 1 or less.
struct OverTool {
  double distance = 0.0;
  Vec3 away;
};

/// Of the end, up to where its rounding is widest. A convex function of the place; beside that upper border
/// it is a little less than the distance.
OverTool over_tool(const ToolPiece& piece, Point<Part> place, Point<Part> ring, Vec3 axis) {
  const Vec3 w = place - ring;
  const double h = dot(w, axis);
  const Vec3 level = w - axis * h;
  const double d = length(level);
  const double side = distance_to_piece(piece, d, h);
  if (h > side) return {h, axis};
  const Vec3 out = d > 0.0 ? level / d : Vec3{};
  const bool on_edge =
      piece.has_cone() ? (d - piece.flat) * piece.taper_sin + h * piece.taper_cos <= 0.0 : h < 0.0;
  if (on_edge) {
    const double beyond = std::max(d - piece.flat, 0.0), off = std::hypot(beyond, h);
    return {side, off > 0.0 ? out * (beyond / off) + axis * (h / off) : Vec3{}};
  }
  if (side <= d - piece.outer) return {side, out};
  return {side, out * piece.taper_cos - axis * piece.taper_sin};
}

double reach_of(const PlanOptions& options, const ToolPiece& piece) {
  return std::hypot(piece.corner, options.only_faces->beyond) - piece.corner + options.tolerance;
}

}  // namespace

FaceContainment::FaceContainment(const PlanOptions& options)
    : tree_(options.only_faces->mesh),
      piece_(tool_pieces(options).front()),
      reach_(reach_of(options, piece_)),
      spacing_(piece_.flat + std::sqrt((2.0 * piece_.corner + reach_) * reach_)),
      slack_(options.tolerance) {}

bool FaceContainment::near(Point<Part> reference, Vec3 axis, double reach) const {
  const Point<Part> ring = reference + axis * piece_.above_reference;
  return tree_.any_along(
      ring, axis, 0.0, 0.0, piece_.flat + piece_.corner + reach,
      [&](std::uint32_t, const PlacedFacet& facet) { return comes_near(facet.corners, ring, axis, reach); });
}

bool FaceContainment::near_ball(Point<Part> centre, double reach) const {
  const double within = piece_.corner + reach;
  return tree_.any_along(centre, {0, 0, 1}, 0.0, 0.0, within, [&](std::uint32_t, const PlacedFacet& facet) {
    return distance(centre, nearest_point(centre, facet.corners)) <= within;
  });
}

/// By halving: over a triangle the function is nowhere less than its tangent plane in the middle.
bool FaceContainment::comes_near(const Corners& corners, Point<Part> ring, Vec3 axis, double reach) const {
  if (over_tool(piece_, nearest_point(ring, corners), ring, axis).distance <= reach) return true;
  std::array<Corners, kMostWaiting> waiting;
  std::size_t count = 0;
  waiting[count++] = corners;
  while (count > 0) {
    const Corners t = waiting[--count];
    const Point<Part> middle = t[0] + ((t[1] - t[0]) + (t[2] - t[0])) / 3.0;
    const OverTool there = over_tool(piece_, middle, ring, axis);
    if (there.distance <= reach) return true;
    double least = there.distance, size = 0.0;
    for (const Point<Part>& corner : t) {
      least = std::min(least, there.distance + dot(there.away, corner - middle));
      size = std::max(size, distance(corner, middle));
    }
    if (least > reach) continue;
    if (size <= kNearlyNear || count + 2 > kMostWaiting) return true;
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (distance(t[k], t[(k + 1) % 3]) > distance(t[longest], t[(longest + 1) % 3])) longest = k;
    const Point<Part> half = lerp(t[longest], t[(longest + 1) % 3], 0.5), other = t[(longest + 2) % 3];
    waiting[count++] = {t[longest], half, other};
    waiting[count++] = {half, t[(longest + 1) % 3], other};
  }
  return false;
}

}  // namespace tiltfeed::pathgen
