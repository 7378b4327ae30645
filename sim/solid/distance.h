#pragma once
// Exact distances between the tool and the part: an own tree of boxes over the facets, in double, that
// shares no code with the planner. A ball end mill with a straight shank is a capsule: all points within
// the radius of the segment from the ball's centre up the axis, so its clearance is that segment's distance
// minus the radius; a negative clearance is the depth of a gouge.

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "sim/solid/triangle.h"

namespace tiltfeed::sim {

/// The answer of a query: a length in mm and the facet it belongs to (index into Mesh::facets). A facet of
/// kNoFacet (kinematics/basics/tool_path.h) means: nothing below the bound, `value` is the bound.
struct Hit {
  double value = kInfinity;
  std::uint32_t facet = 0xFFFFFFFF;
};

inline Vec3 lower(Vec3 a, Vec3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
inline Vec3 upper(Vec3 a, Vec3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

/// Lower bound of the distance between a box and a segment: along the coordinate axes, and along the line
/// from the segment to the box's centre (the segment's point nearest to the centre is extreme there).
struct SegmentBound {
  Vec3 from, along, low, high;
  double whole;

  explicit SegmentBound(const Segment& s)
      : from(from_origin(s.from)),
        along(s.to - s.from),
        low(lower(from, from + along)),
        high(upper(from, from + along)),
        whole(squared_length(along)) {}

  double operator()(Vec3 box_low, Vec3 box_high) const {
    const double dx = std::max({box_low.x - high.x, low.x - box_high.x, 0.0});
    const double dy = std::max({box_low.y - high.y, low.y - box_high.y, 0.0});
    const double dz = std::max({box_low.z - high.z, low.z - box_high.z, 0.0});
    const Vec3 centre = (box_low + box_high) * 0.5, half = (box_high - box_low) * 0.5;
    const Vec3 m = centre - from;
    const double f = whole > 0.0 ? std::clamp(dot(m, along) / whole, 0.0, 1.0) : 0.0;
    const Vec3 u = m - along * f;
    const double reach = std::abs(u.x) * half.x + std::abs(u.y) * half.y + std::abs(u.z) * half.z;
    const double far2 = squared_length(u), straight = std::sqrt(dx * dx + dy * dy + dz * dz);
    return far2 > 0.0 ? std::max(straight, (far2 - reach) / std::sqrt(far2)) : straight;
  }
};

class PartDistance {
 public:
  explicit PartDistance(const pathgen::Mesh& mesh);

  /// Distance from p, if below `bound`.
  Hit nearest(Point<Part> p, double bound = kInfinity, std::uint32_t hint = 0xFFFFFFFF) const;
  /// Distance from the segment, if below `bound`; 0 where it pierces the surface. `hint`: a facet that is
  /// likely near (that of the query before); it only saves time.
  Hit nearest(const Segment& segment, double bound = kInfinity, std::uint32_t hint = 0xFFFFFFFF) const;
  /// The exact drop of the cutter: how far a ball at `centre` moves along `direction` (unit) until it first
  /// touches the part, if below `bound`; 0 when it touches or overlaps where it starts.
  Hit first_touch(Point<Part> centre, Vec3 direction, double radius, double bound = kInfinity,
                  std::uint32_t hint = 0xFFFFFFFF) const;
  /// Any other least value over the facets: visits those that may hold one below `bound`, nearest first, that
  /// of `hint` before all. `lower_bound(low, high)`: of the value over a box; visit(triangle) lowers `bound`.
  template <class LowerBound, class Visit>
  void search(double& bound, std::uint32_t hint, const LowerBound& lower_bound, const Visit& visit) const;
  /// Visits the facets in the boxes of which reaches(low, high, bound, which) is not 0; `which`: what it was
  /// of the box around, at first as given, a bit for each of the bodies that ask together. `bounds`: one for
  /// each box, not less than what visit(facet, which) has said of any facet inside, made anew on the way;
  /// other threads may do the same, when what visit says never grows.
  template <class Reaches, class Visit>
  void descend(std::vector<float>& bounds, std::uint32_t which, const Reaches& reaches,
               const Visit& visit) const {
    if (!nodes_.empty()) descend(0, bounds, which, reaches, visit);
  }
  std::size_t box_count() const { return nodes_.size(); }
  /// Appends the facets that may come within `within` of the segment, some more among them.
  void near(const Segment& segment, double within, std::vector<std::uint32_t>& facets) const;
  /// How often the surface winds round p: 1 inside, 0 outside a closed mesh. Looks at every facet.
  double winding_number(Point<Part> p) const;

  const Triangle& triangle(std::uint32_t facet) const { return triangles_[slot_[facet]]; }
  std::size_t facet_count() const { return triangles_.size(); }

 private:
  struct Node {
    Vec3 low, high;
    std::uint32_t first = 0;  ///< of the children (first, first + 1), or of the triangles
    std::uint32_t count = 0;  ///< of triangles; 0: an inner node
  };
  struct Build;
  static constexpr int kStackSize = 128;
  template <class Reaches, class Visit>
  float descend(std::uint32_t at, std::vector<float>& bounds, std::uint32_t which, const Reaches& reaches,
                const Visit& visit) const;

  std::vector<Triangle> triangles_;  ///< in the order of the leaves
  std::vector<std::uint32_t> slot_;  ///< where facet i is in triangles_
  std::vector<Node> nodes_;
};

/// The tool's axis from the ball's centre to the holder: with a tool of `radius` its clearance is the
/// segment's distance minus the radius. Beyond `shank_length` (from the tip) nothing is checked.
Segment tool_segment(Point<Part> tip, Vec3 axis, double radius, double shank_length);

template <class LowerBound, class Visit>
void PartDistance::search(double& bound, std::uint32_t hint, const LowerBound& lower_bound,
                          const Visit& visit) const {
  struct Waiting {
    std::uint32_t node;
    double least;
  };
  if (nodes_.empty()) return;
  if (hint < slot_.size()) visit(triangles_[slot_[hint]]);
  std::array<Waiting, kStackSize> stack;
  int top = 0;
  stack[top++] = {0, lower_bound(nodes_[0].low, nodes_[0].high)};
  while (top > 0) {
    const Waiting at = stack[--top];
    if (at.least >= bound) continue;
    const Node& node = nodes_[at.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(triangles_[i]);
      continue;
    }
    Waiting near{node.first, lower_bound(nodes_[node.first].low, nodes_[node.first].high)};
    Waiting far{node.first + 1, lower_bound(nodes_[node.first + 1].low, nodes_[node.first + 1].high)};
    if (far.least < near.least) std::swap(near, far);
    assert(top + 2 <= kStackSize);
    if (far.least < bound) stack[top++] = far;
    if (near.least < bound) stack[top++] = near;
  }
}

template <class Reaches, class Visit>
float PartDistance::descend(std::uint32_t at, std::vector<float>& bounds, std::uint32_t which,
                            const Reaches& reaches, const Visit& visit) const {
  const Node& node = nodes_[at];
  const std::atomic_ref<float> stored(bounds[at]);
  const float before = stored.load(std::memory_order_relaxed);
  which = reaches(node.low, node.high, static_cast<double>(before), which);
  if (which == 0) return before;
  float bound = -std::numeric_limits<float>::infinity();
  if (node.count == 0)
    for (const std::uint32_t child : {node.first, node.first + 1})
      bound = std::max(bound, descend(child, bounds, which, reaches, visit));
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
    bound = std::max(bound, visit(triangles_[i].facet, which));
  if (bound < before) stored.store(bound, std::memory_order_relaxed);
  return bound;
}

}  // namespace tiltfeed::sim
