#include "pathgen/facet_tree.h"

#include <algorithm>
#include <numeric>

namespace tiltfeed {

namespace {

constexpr std::uint32_t kLeafFacets = 4;
/// Places where the cost of a cut is tried, each way.
constexpr int kBins = 16;

double area(Vec3 low, Vec3 high) {
  const Vec3 d = high - low;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

Vec3 lower(Vec3 a, Vec3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3 upper(Vec3 a, Vec3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }
double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

struct Bounds {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  std::uint32_t count = 0;
  void add(const Bounds& b) { low = lower(low, b.low), high = upper(high, b.high), count += b.count; }
};

/// Of the smallest ball about three places: the middle of the longest side, or the middle of the circle
/// through all three where no angle is obtuse.
Point<Part> ball_centre(Point<Part> a, Point<Part> b, Point<Part> c) {
  const Vec3 u = b - a, v = c - a, w = c - b;
  const double uu = squared_length(u), vv = squared_length(v), ww = squared_length(w);
  if (uu >= vv + ww) return lerp(a, b, 0.5);
  if (vv >= uu + ww) return lerp(a, c, 0.5);
  if (ww >= uu + vv) return lerp(b, c, 0.5);
  const Vec3 n = cross(u, v);
  return a + (cross(n, u) * vv + cross(v, n) * uu) / (2.0 * squared_length(n));
}

}  // namespace

/// Halves each node where the areas of the halves, times their facets, are least.
struct FacetTree::Builder {
  std::vector<Bounds> box;
  std::vector<std::uint32_t> order;
  std::vector<Node>& nodes;

  Bounds bounds(std::uint32_t from, std::uint32_t to) const {
    Bounds all;
    for (std::uint32_t i = from; i < to; ++i) all.add(box[order[i]]);
    return all;
  }

  Vec3 centre(std::uint32_t facet) const { return (box[facet].low + box[facet].high) * 0.5; }

  /// Where the facets from..to are cut in two, having put those below the cut first; the middle where no cut
  /// is better than another.
  std::uint32_t cut(std::uint32_t from, std::uint32_t to) {
    Bounds centres;
    for (std::uint32_t i = from; i < to; ++i) centres.add({centre(order[i]), centre(order[i]), 1});
    const Vec3 size = centres.high - centres.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const double low = component(centres.low, axis), whole = component(size, axis);
    const std::uint32_t middle = from + (to - from) / 2;
    const auto bin = [&](std::uint32_t f) {
      return std::min(kBins - 1, static_cast<int>((component(centre(f), axis) - low) / whole * kBins));
    };
    if (!(whole > 0.0)) return middle;
    std::array<Bounds, kBins> bins;
    for (std::uint32_t i = from; i < to; ++i) bins[bin(order[i])].add(box[order[i]]);
    std::array<double, kBins> above{};
    Bounds sum;
    for (int i = kBins - 1; i > 0; --i)
      sum.add(bins[i]), above[i] = sum.count > 0 ? area(sum.low, sum.high) * sum.count : 0.0;
    sum = {};
    double best = std::numeric_limits<double>::infinity();
    int at = 0;
    for (int i = 0; i + 1 < kBins; ++i) {
      sum.add(bins[i]);
      if (sum.count == 0 || sum.count == to - from) continue;
      const double cost = area(sum.low, sum.high) * sum.count + above[i + 1];
      if (cost < best) best = cost, at = i;
    }
    const auto first = order.begin() + from, last = order.begin() + to;
    const auto found = std::stable_partition(first, last, [&](std::uint32_t f) { return bin(f) <= at; });
    return found == first || found == last ? middle : static_cast<std::uint32_t>(found - order.begin());
  }

  void build(std::uint32_t node, std::uint32_t from, std::uint32_t to, int depth) {
    const Bounds all = bounds(from, to);
    nodes[node].low = all.low, nodes[node].high = all.high;
    if (to - from <= kLeafFacets) {
      nodes[node].first = from, nodes[node].count = to - from;
      return;
    }
    // Cuts that take off little would make the tree deeper than the walk's stack.
    const std::uint32_t middle = depth < kStackSize / 2 ? cut(from, to) : from + (to - from) / 2;
    const auto child = static_cast<std::uint32_t>(nodes.size());
    nodes[node].first = child;
    nodes.resize(nodes.size() + 2);
    build(child, from, middle, depth + 1);
    build(child + 1, middle, to, depth + 1);
  }
};

FacetTree::FacetTree(const Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.facets.size());
  if (count == 0) return;
  Builder builder{std::vector<Bounds>(count), std::vector<std::uint32_t>(count), nodes_};
  std::iota(builder.order.begin(), builder.order.end(), 0u);
  for (std::uint32_t f = 0; f < count; ++f) {
    for (const std::uint32_t v : mesh.facets[f])
      builder.box[f].add({from_origin(mesh.vertices[v]), from_origin(mesh.vertices[v]), 0});
    builder.box[f].count = 1;
  }
  nodes_.reserve(count);
  nodes_.resize(1);
  builder.build(0, 0, count, 0);
  facet_ = std::move(builder.order);
  slot_.resize(count), placed_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto& f = mesh.facets[facet_[i]];
    slot_[facet_[i]] = i;
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const Vec3 n = normalized(cross(b - a, c - a));
    const Point<Part> centre = ball_centre(a, b, c);
    placed_[i] = {{a, b, c},
                  n,
                  dot(n, from_origin(a)),
                  centre,
                  std::max({distance(centre, a), distance(centre, b), distance(centre, c)})};
  }
  const Node& root = nodes_.front();
  bounds_ = {{root.low.x, root.low.y, root.low.z}, {root.high.x, root.high.y, root.high.z}};
}

}  // namespace tiltfeed
