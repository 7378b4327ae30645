#pragma once
// A patch of the part as the tool beside it sees it: how far things are over its plane and beyond its edges.

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/removal/probes.h"

namespace tiltfeed::sim {

/// A patch's plane and edges: what is pushed along is over the one and beyond the others.
struct Facet {
  std::uint32_t patch = 0;
  Point<Part> middle;
  Vec3 normal;
  double radius = 0.0;           ///< of the circle about its corners, mm
  std::array<Vec3, 3> out{};     ///< unit, in the plane, out over each edge; zero without area
  std::array<double, 3> edge{};  ///< of the middle from each edge, mm

  Facet(const Patches& patches, const Triangle& t, std::uint32_t the_patch)
      : patch(the_patch),
        middle(patches.middle[the_patch]),
        normal(patches.normal[the_patch]),
        radius(static_cast<double>(patches.radius[the_patch])) {
    // The coordinates of the middle are a third each.
    const std::array<Vec3, 3> inward{t.grad_v, t.grad_w, Vec3{} - t.grad_v - t.grad_w};
    for (std::size_t k = 0; k < inward.size(); ++k) {
      const double square = squared_length(inward[k]), height = square > 0.0 ? 1.0 / std::sqrt(square) : 0.0;
      out[k] = inward[k] * -height, edge[k] = height / 3.0;
    }
  }

  /// Of a convex body, mm: not more than the height of its points over the plane, and than their way beyond
  /// the patch, along the plane.
  struct Off {
    double over = kInfinity, beyond = 0.0;
  };
  template <std::size_t kCount>
  Off off(const std::array<Point<Part>, kCount>& corners) const {
    double over = kInfinity;
    std::array<double, 3> least{kInfinity, kInfinity, kInfinity};
    for (const Point<Part> corner : corners) {
      const Vec3 from = corner - middle;
      over = std::min(over, dot(normal, from));
      for (std::size_t k = 0; k < out.size(); ++k) least[k] = std::min(least[k], dot(out[k], from));
    }
    const double beyond = std::max({least[0] - edge[0], least[1] - edge[1], least[2] - edge[2]});
    return {over, std::max(0.0, beyond - kBoundSlack)};
  }
  /// Could the body be within `near` of the patch?
  template <std::size_t kCount>
  bool meets(const std::array<Point<Part>, kCount>& corners, double near) const {
    const Off far = off(corners);
    const double over = std::max(0.0, far.over);
    return near > 0.0 && over * over + far.beyond * far.beyond < near * near;
  }
  /// Could the segment come within `near` of the patch? The patch is in the half plane within each edge. Seen
  /// along that edge the segment has a place (beyond it, over the plane), and the half plane is a ray.
  bool meets(const Segment& s, double near) const {
    if (near <= 0.0) return false;
    const Vec3 from = s.from - middle, to = s.to - middle;
    const double y = dot(normal, from), y_end = dot(normal, to), within2 = near * near;
    if (y * y_end > 0.0 && std::min(y * y, y_end * y_end) >= within2) return false;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const double x = dot(out[k], from) - edge[k] - kBoundSlack,
                   x_end = dot(out[k], to) - edge[k] - kBoundSlack;
      if (x <= 0.0 && x_end <= 0.0) continue;
      const double dx = x_end - x, dy = y_end - y;
      // From the ray's end to the segment, and where that is not the way, from the ray to the end over it.
      if (x <= 0.0 && (y * (y * dx - x * dy) <= 0.0 || y * y < within2)) continue;
      if (x_end <= 0.0 && (y_end * (x * dy - y * dx) <= 0.0 || y_end * y_end < within2)) continue;
      const double along = x * dx + y * dy, square = dx * dx + dy * dy;
      const double cross = x * dy - y * dx;
      const bool far = along >= 0.0                     ? x * x + y * y >= within2
                       : x_end * dx + y_end * dy <= 0.0 ? x_end * x_end + y_end * y_end >= within2
                                                        : cross * cross >= within2 * square;
      if (far) return false;
    }
    return true;
  }
};

}  // namespace tiltfeed::sim
