#include "sim/solid/distance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "kinematics/basics/tool_path.h"
#include "sim/solid/half_edges.h"

namespace tiltfeed::sim {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr int kBins = 16;
// From this depth on halves are equal, which bounds the depth by kEvenDepth + log2(facets).
constexpr int kEvenDepth = 40;

double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

struct Bounds {
  Vec3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  void add(Vec3 p) { low = lower(low, p), high = upper(high, p); }
  void add(const Bounds& b) { low = lower(low, b.low), high = upper(high, b.high); }
  double half_area() const {
    const Vec3 e = high - low;
    return e.x < 0.0 ? 0.0 : e.x * e.y + e.y * e.z + e.z * e.x;
  }
};

/// Triangle::owned of each facet: the edges and corners that no facet before it has.
std::vector<std::uint8_t> share_out(const pathgen::Mesh& mesh) {
  std::vector<std::uint8_t> owned(mesh.facets.size(), 0);
  std::vector<bool> corner_taken(mesh.vertices.size(), false);
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = mesh.facets[i][k];
      if (corner_taken[from]) continue;
      corner_taken[from] = true;
      owned[i] = static_cast<std::uint8_t>(owned[i] | 8u << k);
    }
  }
  const std::vector<HalfEdge> halves = half_edges(mesh.facets, mesh.vertices.size());
  for (std::size_t e = 0; e < halves.size(); ++e) {
    const HalfEdge& half = halves[e];
    if (e > 0 && halves[e - 1].low == half.low && halves[e - 1].high == half.high) continue;
    owned[half.facet] = static_cast<std::uint8_t>(owned[half.facet] | 1u << half.side);
  }
  return owned;
}

/// Where a ray enters a box grown by `radius`; kInfinity when it misses.
struct SweepBound {
  Vec3 centre, inverse;
  double radius;

  static double invert(double d) { return std::abs(d) < 1e-300 ? std::copysign(1e300, d) : 1.0 / d; }
  SweepBound(Point<Part> c, Vec3 d, double r)
      : centre(from_origin(c)), inverse{invert(d.x), invert(d.y), invert(d.z)}, radius(r) {}

  double operator()(Vec3 low, Vec3 high) const {
    double enter = 0.0, leave = kInfinity;
    const auto slab = [&](double from, double lo, double hi, double inv) {
      const double a = (lo - radius - from) * inv, b = (hi + radius - from) * inv;
      enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
    };
    slab(centre.x, low.x, high.x, inverse.x);
    slab(centre.y, low.y, high.y, inverse.y);
    slab(centre.z, low.z, high.z, inverse.z);
    return enter <= leave ? enter : kInfinity;
  }
};

}  // namespace

/// Splits the facets top down where the surface area heuristic is least, among kBins places on the longest
/// side of the box round the facets' centres.
struct PartDistance::Build {
  PartDistance& tree;
  std::vector<Bounds> boxes;
  std::vector<Vec3> centres;
  std::vector<std::uint32_t> order;

  void fill(std::uint32_t node, std::uint32_t begin, std::uint32_t end, int depth) {
    Bounds box, span;
    for (std::uint32_t i = begin; i < end; ++i) box.add(boxes[order[i]]), span.add(centres[order[i]]);
    tree.nodes_[node].low = box.low, tree.nodes_[node].high = box.high;
    if (end - begin <= kLeafSize) {
      tree.nodes_[node].first = begin, tree.nodes_[node].count = end - begin;
      return;
    }
    const Vec3 size = span.high - span.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    std::uint32_t middle = depth < kEvenDepth ? split(begin, end, axis, span) : begin;
    if (middle == begin || middle == end) {
      middle = begin + (end - begin) / 2;
      std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                       [&](std::uint32_t a, std::uint32_t b) {
                         const double ca = component(centres[a], axis), cb = component(centres[b], axis);
                         return ca != cb ? ca < cb : a < b;
                       });
    }
    const auto children = static_cast<std::uint32_t>(tree.nodes_.size());
    tree.nodes_[node].first = children;
    tree.nodes_.resize(tree.nodes_.size() + 2);
    fill(children, begin, middle, depth + 1);
    fill(children + 1, middle, end, depth + 1);
  }

  std::uint32_t split(std::uint32_t begin, std::uint32_t end, int axis, const Bounds& span) {
    const double low = component(span.low, axis), size = component(span.high, axis) - low;
    if (!(size > 0.0)) return begin;
    const auto bin_of = [&](std::uint32_t i) {
      return std::min(kBins - 1, static_cast<int>((component(centres[i], axis) - low) / size * kBins));
    };
    std::array<Bounds, kBins> bin;
    std::array<std::uint32_t, kBins> count{};
    for (std::uint32_t i = begin; i < end; ++i) {
      const int b = bin_of(order[i]);
      bin[b].add(boxes[order[i]]), ++count[b];
    }
    std::array<double, kBins> right_cost{};
    Bounds right;
    std::uint32_t right_count = 0;
    for (int b = kBins - 1; b > 0; --b) {
      right.add(bin[b]), right_count += count[b];
      right_cost[b] = right.half_area() * right_count;
    }
    Bounds left;
    std::uint32_t left_count = 0;
    int best = 0;
    double best_cost = kInfinity;
    for (int b = 1; b < kBins; ++b) {
      left.add(bin[b - 1]), left_count += count[b - 1];
      const double cost = left.half_area() * left_count + right_cost[b];
      if (left_count > 0 && left_count < end - begin && cost < best_cost) best_cost = cost, best = b;
    }
    const auto middle = std::stable_partition(order.begin() + begin, order.begin() + end,
                                              [&](std::uint32_t i) { return bin_of(i) < best; });
    return static_cast<std::uint32_t>(middle - order.begin());
  }
};

PartDistance::PartDistance(const pathgen::Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.facets.size());
  if (count == 0) return;
  Build build{*this, std::vector<Bounds>(count), std::vector<Vec3>(count), std::vector<std::uint32_t>(count)};
  for (std::uint32_t i = 0; i < count; ++i) {
    for (const std::uint32_t corner : mesh.facets[i]) build.boxes[i].add(from_origin(mesh.vertices[corner]));
    build.centres[i] = (build.boxes[i].low + build.boxes[i].high) * 0.5;
  }
  std::iota(build.order.begin(), build.order.end(), 0u);
  nodes_.reserve(count);
  nodes_.resize(1);
  build.fill(0, 0, count, 0);
  const std::vector<std::uint8_t> owned = share_out(mesh);
  triangles_.reserve(count);
  slot_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t facet = build.order[i];
    const auto& [a, b, c] = mesh.facets[facet];
    slot_[facet] = i;
    triangles_.push_back(make_triangle(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], facet));
    triangles_.back().owned = owned[facet];
  }
}

Hit PartDistance::nearest(Point<Part> p, double bound, std::uint32_t hint) const {
  return nearest(Segment{p, p}, bound, hint);
}

Hit PartDistance::nearest(const Segment& segment, double bound, std::uint32_t hint) const {
  Hit hit{bound, kNoFacet};
  const bool is_point = segment.from == segment.to;
  const auto visit = [&](const Triangle& t) {
    const double d2 = is_point ? squared_distance(t, segment.from) : squared_distance(t, segment);
    if (d2 < hit.value * hit.value) hit = {std::sqrt(d2), t.facet};
  };
  search(hit.value, hint, SegmentBound(segment), visit);
  return hit;
}

Hit PartDistance::first_touch(Point<Part> centre, Vec3 direction, double radius, double bound,
                              std::uint32_t hint) const {
  Hit hit{bound, kNoFacet};
  const auto visit = [&](const Triangle& t) {
    const double s = sim::first_touch(t, centre, direction, radius, hit.value);
    if (s < hit.value) hit = {s, t.facet};
  };
  search(hit.value, hint, SweepBound(centre, direction, radius), visit);
  return hit;
}

void PartDistance::near(const Segment& segment, double within, std::vector<std::uint32_t>& facets) const {
  search(within, kNoFacet, SegmentBound(segment), [&](const Triangle& t) { facets.push_back(t.facet); });
}

double PartDistance::winding_number(Point<Part> p) const {
  double sum = 0.0;
  for (const Triangle& t : triangles_) sum += solid_angle(t, p);
  return sum / (4.0 * kPi);
}

Segment tool_segment(Point<Part> tip, Vec3 axis, double radius, double shank_length) {
  return {tip + axis * radius, tip + axis * std::max(radius, shank_length)};
}

}  // namespace tiltfeed::sim
