#pragma once
// The facets of a part in a tree of boxes, in double: who is near a place, a segment or a ray.

#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "pathgen/mesh.h"

namespace tiltfeed {

using Corners = std::array<Point<Part>, 3>;

/// A facet with its plane, normal.p = offset, and a ball about it.
struct PlacedFacet {
  Corners corners;
  Vec3 normal;  ///< unit
  double offset = 0.0;
  Point<Part> centre;
  double radius = 0.0;
};

class FacetTree {
 public:
  explicit FacetTree(const Mesh& mesh);

  const Box& bounds() const { return bounds_; }
  /// Facet i of the mesh.
  const PlacedFacet& facet(std::uint32_t facet) const { return placed_[slot_[facet]]; }

  /// Calls visit(index, facet) for every facet whose box comes within `reach` (mm) of the ray from + t
  /// direction, first <= t <= last, the near ones first as a rule, until it returns true; true if one did.
  /// Facets further off may be visited, too. Requires: direction unit, first <= last.
  template <class Visit>
  bool any_along(Point<Part> from, Vec3 direction, double first, double last, double reach,
                 const Visit& visit) const;

  /// Calls visit(index, facet) for every facet whose box overlaps `box`.
  template <class Visit>
  void each_in(const Box& box, const Visit& visit) const;

 private:
  struct Node {
    Vec3 low, high;
    std::uint32_t first = 0;  ///< the children are first and first + 1; or the first facet's slot
    std::uint32_t count = 0;  ///< of facets; 0: an inner node
  };
  struct Builder;
  static constexpr int kStackSize = 128;

  std::vector<PlacedFacet> placed_;   ///< in the order of the leaves
  std::vector<std::uint32_t> facet_;  ///< of each slot
  std::vector<std::uint32_t> slot_;   ///< of each facet
  std::vector<Node> nodes_;
  Box bounds_{};
};

template <class Visit>
bool FacetTree::any_along(Point<Part> from, Vec3 direction, double first, double last, double reach,
                          const Visit& visit) const {
  if (nodes_.empty()) return false;
  // No component is 0: 1e-30 mm per mm bends nothing.
  const auto inverse = [](double d) { return 1.0 / (std::abs(d) < 1e-30 ? std::copysign(1e-30, d) : d); };
  const Vec3 o = from_origin(from), inv{inverse(direction.x), inverse(direction.y), inverse(direction.z)};
  const auto entry = [&](const Node& n) {
    const double x0 = (n.low.x - reach - o.x) * inv.x, x1 = (n.high.x + reach - o.x) * inv.x;
    const double y0 = (n.low.y - reach - o.y) * inv.y, y1 = (n.high.y + reach - o.y) * inv.y;
    const double z0 = (n.low.z - reach - o.z) * inv.z, z1 = (n.high.z + reach - o.z) * inv.z;
    const double in =
        std::max(std::max(std::min(x0, x1), std::min(y0, y1)), std::max(std::min(z0, z1), first));
    const double out =
        std::min(std::min(std::max(x0, x1), std::max(y0, y1)), std::min(std::max(z0, z1), last));
    return in <= out ? in : std::numeric_limits<double>::infinity();
  };
  constexpr double kMissed = std::numeric_limits<double>::infinity();
  if (entry(nodes_[0]) == kMissed) return false;
  std::array<std::uint32_t, kStackSize> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        if (visit(facet_[i], placed_[i])) return true;
      continue;
    }
    double near = entry(nodes_[node.first]), far = entry(nodes_[node.first + 1]);
    std::uint32_t near_node = node.first, far_node = node.first + 1;
    if (far < near) std::swap(near, far), std::swap(near_node, far_node);
    assert(top + 2 <= kStackSize);
    if (far != kMissed) stack[top++] = far_node;
    if (near != kMissed) stack[top++] = near_node;
  }
  return false;
}

template <class Visit>
void FacetTree::each_in(const Box& box, const Visit& visit) const {
  if (nodes_.empty()) return;
  std::array<std::uint32_t, kStackSize> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (node.low.x > box.max.x || node.high.x < box.min.x || node.low.y > box.max.y ||
        node.high.y < box.min.y || node.low.z > box.max.z || node.high.z < box.min.z)
      continue;
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(facet_[i], placed_[i]);
      continue;
    }
    assert(top + 2 <= kStackSize);
    stack[top++] = node.first + 1;
    stack[top++] = node.first;
  }
}

}  // namespace tiltfeed
