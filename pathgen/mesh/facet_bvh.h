#pragma once
// The facets of a part in a tree of boxes: who is near a place, a segment or a ray. The boxes, four at a
// time, are of single precision and a little wider than what is in them; they only rule out.

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pathgen/mesh/float_lanes.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

using Corners = std::array<Point<Part>, 3>;

/// A facet with its plane, normal.p = offset, and a ball about it.
struct PlacedFacet {
  Corners corners;
  Vec3 normal;  ///< unit
  double offset = 0.0;
  Point<Part> centre;
  double radius = 0.0;
};

class FacetBvh {
 public:
  explicit FacetBvh(const Mesh& mesh);

  const Box& bounds() const { return bounds_; }
  /// Facet i of the mesh.
  const PlacedFacet& facet(std::uint32_t facet) const { return placed_[slot_[facet]]; }

  /// Calls visit(index, facet) for every facet that comes within `reach` (mm) of the ray from + t direction,
  /// first <= t <= last, the near ones first as a rule, until it returns true; true if one did. Facets
  /// further off may be visited, too. Requires: direction unit, first <= last.
  template <class Visit>
  bool any_along(Point<Part> from, Vec3 direction, double first, double last, double reach,
                 const Visit& visit) const {
    return any_near(ray_lanes(from, direction, first, last, reach, reach), visit);
  }
  /// The same for every facet of which something is within `reach` of the whole line and between the heights
  /// `first` and `last` along it.
  template <class Visit>
  bool any_in_cylinder(Point<Part> from, Vec3 direction, double first, double last, double reach,
                       const Visit& visit) const {
    return any_near(ray_lanes(from, direction, first, last, reach, 0.0), visit);
  }

  /// Calls visit(index, facet) for every facet whose box overlaps `box`.
  template <class Visit>
  void each_in(const Box& box, const Visit& visit) const;

  /// Calls visit(index, facet) for facets by and by until none is left that may be nearer to p (mm) than the
  /// least that it returned, or than `reach`.
  template <class Visit>
  void nearest(Point<Part> p, double reach, const Visit& visit) const;

 private:
  /// Coordinates from the part's middle.
  struct Node {
    FourBoxes boxes;
    std::array<std::uint32_t, 4> first;  ///< the node in it; or the first of its facets' slots
    std::array<std::uint32_t, 4> count;  ///< of facets; 0: a node
  };
  struct Builder;
  static constexpr int kStackSize = 256;

  void place(const Mesh& mesh, std::uint32_t slot);
  template <class Visit>
  bool any_near(const RayLanes& ray, const Visit& visit) const;
  /// `ends`: by how much more than its first and last the ray's heights are.
  /// Squares of the distances from p, from the part's middle, to the boxes; a little less.
  static Lanes square_to(const FourBoxes& boxes, const std::array<Lanes, 3>& p);
  RayLanes ray_lanes(Point<Part> from, Vec3 direction, double first, double last, double reach,
                     double ends) const;
  /// Which of the slots' balls come near it.
  unsigned balls_met(std::uint32_t slot, const RayLanes& probe) const;

  std::vector<PlacedFacet> placed_;   ///< in the order of the leaves
  std::vector<std::uint32_t> facet_;  ///< of each slot
  std::vector<std::uint32_t> slot_;   ///< of each facet
  std::array<std::vector<float>, 4>
      balls_;  ///< of each slot: centre, from the part's middle, and radius; and four more
  std::vector<Node> nodes_;
  Box bounds_{};
  Point<Part> middle_{};
  double spare_ = 0.0;  ///< by which rounding may be off, mm
};

inline unsigned FacetBvh::balls_met(std::uint32_t slot, const RayLanes& p) const {
  const Lanes at_x = load_lanes(&balls_[0][slot]), at_y = load_lanes(&balls_[1][slot]),
              at_z = load_lanes(&balls_[2][slot]), r = load_lanes(&balls_[3][slot]);
  const Lanes height = at_x * p.direction[0] + at_y * p.direction[1] + at_z * p.direction[2];
  const Lanes x = at_x - p.from[0], y = at_y - p.from[1], z = at_z - p.from[2];
  const Lanes along = x * p.direction[0] + y * p.direction[1] + z * p.direction[2];
  const Lanes far = x * x + y * y + z * z, reach = r + p.reach;
  // Single precision takes one from the other to 1e-6 of them.
  return no_more(far - along * along, reach * reach + far * 1e-6f) & no_more(p.least_height, height + r) &
         no_more(height - r, p.most_height);
}

template <class Visit>
bool FacetBvh::any_near(const RayLanes& ray, const Visit& visit) const {
  if (nodes_.empty()) return false;
  std::array<std::uint32_t, kStackSize> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    Lanes entry;
    std::array<float, 4> at_entry;
    const int base = top;
    unsigned met = boxes_between(node.boxes, ray);
    if (met != 0) met &= boxes_met(node.boxes, ray, entry);
    for (; met != 0; met &= met - 1) {
      const int lane = std::countr_zero(met);
      const std::uint32_t at = node.first[lane];
      if (node.count[lane] > 0) {
        unsigned near = balls_met(at, ray) & ((1u << node.count[lane]) - 1);
        for (; near != 0; near &= near - 1) {
          const std::uint32_t slot = at + static_cast<std::uint32_t>(std::countr_zero(near));
          if (visit(facet_[slot], placed_[slot])) return true;
        }
        continue;
      }
      assert(top < kStackSize);
      int place = top++;  // the nearest on top
      for (; place > base && at_entry[place - 1 - base] < entry[lane]; --place)
        stack[place] = stack[place - 1], at_entry[place - base] = at_entry[place - 1 - base];
      stack[place] = at, at_entry[place - base] = entry[lane];
    }
  }
  return false;
}

template <class Visit>
void FacetBvh::each_in(const Box& box, const Visit& visit) const {
  if (nodes_.empty()) return;
  const Vec3 low = box.min - middle_ - Vec3{spare_, spare_, spare_},
             high = box.max - middle_ + Vec3{spare_, spare_, spare_};
  const std::array<Lanes, 3> from{all_lanes(static_cast<float>(low.x)), all_lanes(static_cast<float>(low.y)),
                                  all_lanes(static_cast<float>(low.z))},
      to{all_lanes(static_cast<float>(high.x)), all_lanes(static_cast<float>(high.y)),
         all_lanes(static_cast<float>(high.z))};
  std::array<std::uint32_t, kStackSize> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    unsigned met = 15;
    for (std::size_t k = 0; k < 3; ++k)
      met &= no_more(node.boxes.low[k], to[k]) & no_more(from[k], node.boxes.high[k]);
    for (; met != 0; met &= met - 1) {
      const int lane = std::countr_zero(met);
      const std::uint32_t at = node.first[lane];
      for (std::uint32_t i = at; i < at + node.count[lane]; ++i) visit(facet_[i], placed_[i]);
      if (node.count[lane] > 0) continue;
      assert(top < kStackSize);
      stack[top++] = at;
    }
  }
}

inline Lanes FacetBvh::square_to(const FourBoxes& boxes, const std::array<Lanes, 3>& p) {
  Lanes sum = all_lanes(0.0f);
  for (std::size_t k = 0; k < 3; ++k) {
    const Lanes off = greater(greater(boxes.low[k] - p[k], p[k] - boxes.high[k]), all_lanes(0.0f));
    sum += off * off;
  }
  return sum * all_lanes(1.0f - 1e-5f);  // single precision
}

template <class Visit>
void FacetBvh::nearest(Point<Part> p, double reach, const Visit& visit) const {
  if (nodes_.empty()) return;
  const Vec3 place = p - middle_;
  const std::array<Lanes, 3> at{all_lanes(static_cast<float>(place.x)),
                                all_lanes(static_cast<float>(place.y)),
                                all_lanes(static_cast<float>(place.z))};
  // Where p and the boxes stand is rounded.
  const double spare = spare_ + 1e-6 * length(place);
  double least = reach;
  const auto may_be_nearer = [&](float square) {
    return std::sqrt(static_cast<double>(square)) <= least + spare;
  };
  struct Entry {
    std::uint32_t first = 0, count = 0;  // as in Node
    float square = 0.0f;
  };
  std::array<Entry, kStackSize> stack;
  int top = 0;
  stack[top++] = {};
  while (top > 0) {
    const Entry next = stack[--top];
    if (!may_be_nearer(next.square)) continue;
    for (std::uint32_t slot = next.first; slot < next.first + next.count; ++slot)
      least = std::min(least, visit(facet_[slot], placed_[slot]));
    if (next.count > 0) continue;
    const Node& node = nodes_[next.first];
    const Lanes squares = square_to(node.boxes, at);
    const int base = top;
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const float square = squares[lane];
      const bool empty = node.count[lane] == 0 && node.first[lane] == 0;
      if (empty || !may_be_nearer(square)) continue;
      assert(top < kStackSize);
      int to = top++;  // the nearest on top
      for (; to > base && stack[to - 1].square < square; --to) stack[to] = stack[to - 1];
      stack[to] = {node.first[lane], node.count[lane], square};
    }
  }
}

}  // namespace tiltfeed::pathgen
