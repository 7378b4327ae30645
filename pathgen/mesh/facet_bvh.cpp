#include "pathgen/mesh/facet_bvh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tiltfeed::pathgen {

namespace {

constexpr std::uint32_t kLeafFacets = 4;
/// Places where the cost of a cut is tried, each way.
constexpr int kBins = 16;
/// Cuts that take off little would make the tree deeper than the walk's stack: so deep at most, then halves.
constexpr int kMostCuts = 48;
/// Single precision: coordinates and sums of them are right to this share of the largest.
constexpr double kRounding = 1e-6;
/// Components of a direction below this bend a ray by less than its rounding.
constexpr double kLevel = 1e-9;

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

/// Halves each range of facets where the areas of the halves, times their facets, are least.
struct FacetBvh::Builder {
  struct Half {
    Bounds box;
    std::uint32_t from = 0, to = 0;  ///< of the order
    int depth = 0;
  };
  std::vector<Bounds> box;
  std::vector<std::uint32_t> order;
  std::vector<Node>& nodes;
  Vec3 middle;
  double spare;

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
    const std::uint32_t half_way = from + (to - from) / 2;
    const auto bin = [&](std::uint32_t f) {
      return std::min(kBins - 1, static_cast<int>((component(centre(f), axis) - low) / whole * kBins));
    };
    if (!(whole > 0.0)) return half_way;
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
    return found == first || found == last ? half_way : static_cast<std::uint32_t>(found - order.begin());
  }

  Half half(std::uint32_t from, std::uint32_t to, int depth) const {
    return {bounds(from, to), from, to, depth};
  }

  /// Up to four parts of the range: the one of the largest box is halved until there are.
  std::vector<Half> parts(const Half& whole) {
    std::vector<Half> found{whole};
    while (found.size() < 4) {
      std::size_t widest = found.size();
      for (std::size_t i = 0; i < found.size(); ++i)
        if (found[i].to - found[i].from > kLeafFacets &&
            (widest == found.size() ||
             area(found[i].box.low, found[i].box.high) > area(found[widest].box.low, found[widest].box.high)))
          widest = i;
      if (widest == found.size()) break;
      const Half h = found[widest];
      const std::uint32_t middle_of = h.depth < kMostCuts ? cut(h.from, h.to) : h.from + (h.to - h.from) / 2;
      found[widest] = half(h.from, middle_of, h.depth + 1);
      found.insert(found.begin() + static_cast<std::ptrdiff_t>(widest) + 1,
                   half(middle_of, h.to, h.depth + 1));
    }
    return found;
  }

  /// The node of the range; its index.
  std::uint32_t build(const Half& whole) {
    const auto index = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    const float nowhere = std::numeric_limits<float>::max();
    for (std::size_t k = 0; k < 3; ++k)
      nodes[index].boxes.low[k] = all_lanes(nowhere), nodes[index].boxes.high[k] = all_lanes(-nowhere);
    const std::vector<Half> found = parts(whole);
    for (std::size_t lane = 0; lane < found.size(); ++lane) {
      const Half& h = found[lane];
      for (int k = 0; k < 3; ++k) {
        nodes[index].boxes.low[k][lane] =
            static_cast<float>(component(h.box.low, k) - component(middle, k) - spare);
        nodes[index].boxes.high[k][lane] =
            static_cast<float>(component(h.box.high, k) - component(middle, k) + spare);
      }
      const bool leaf = h.to - h.from <= kLeafFacets;
      const std::uint32_t first = leaf ? h.from : build(h);
      nodes[index].first[lane] = first, nodes[index].count[lane] = leaf ? h.to - h.from : 0;
    }
    return index;
  }
};

RayLanes FacetBvh::ray_lanes(Point<Part> from, Vec3 direction, double first, double last, double reach,
                             double ends) const {
  const Vec3 o = from - middle_;
  const double spare = spare_ + kRounding * (length(o) + reach);
  const std::array<double, 3> at{o.x, o.y, o.z}, d{direction.x, direction.y, direction.z};
  RayLanes p{};
  const double wide = reach + spare;
  for (std::size_t k = 0; k < 3; ++k) {
    const double bent = std::abs(d[k]) < kLevel ? std::copysign(kLevel, d[k]) : d[k];
    p.low[k] = all_lanes(static_cast<float>(at[k] + wide));
    p.high[k] = all_lanes(static_cast<float>(at[k] - wide));
    p.inverse[k] = all_lanes(static_cast<float>(1.0 / bent)), p.backwards[k] = bent < 0.0;
    p.from[k] = all_lanes(static_cast<float>(at[k])), p.direction[k] = all_lanes(static_cast<float>(d[k]));
  }
  p.first = all_lanes(static_cast<float>(first - spare - kRounding * std::abs(first)));
  p.last = all_lanes(static_cast<float>(std::min(last, 1e30) * (1.0 + kRounding) + spare));
  p.reach = all_lanes(static_cast<float>(wide));
  const double height = dot(o, direction);
  p.least_height = all_lanes(static_cast<float>(height + first - ends - spare - kRounding * std::abs(first)));
  p.most_height =
      all_lanes(static_cast<float>(height + std::min(last, 1e30) * (1.0 + kRounding) + ends + spare));
  return p;
}

FacetBvh::FacetBvh(const Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.facets.size());
  if (count == 0) return;
  Builder builder{std::vector<Bounds>(count), std::vector<std::uint32_t>(count), nodes_, {}, 0.0};
  std::iota(builder.order.begin(), builder.order.end(), 0u);
  for (std::uint32_t f = 0; f < count; ++f) {
    for (const std::uint32_t v : mesh.facets[f])
      builder.box[f].add({from_origin(mesh.vertices[v]), from_origin(mesh.vertices[v]), 0});
    builder.box[f].count = 1;
  }
  const Builder::Half all = builder.half(0, count, 0);
  bounds_ = {{all.box.low.x, all.box.low.y, all.box.low.z}, {all.box.high.x, all.box.high.y, all.box.high.z}};
  middle_ = lerp(bounds_.min, bounds_.max, 0.5);
  spare_ = kRounding * distance(bounds_.min, bounds_.max);
  builder.middle = from_origin(middle_), builder.spare = spare_;
  nodes_.reserve(count / 4 + 1);
  builder.build(all);
  facet_ = std::move(builder.order);
  slot_.resize(count), placed_.resize(count);
  for (std::vector<float>& of : balls_) of.assign(count + kLeafFacets, 0.0f);
  for (std::uint32_t i = 0; i < count; ++i) place(mesh, i);
}

void FacetBvh::place(const Mesh& mesh, std::uint32_t slot) {
  const auto& f = mesh.facets[facet_[slot]];
  slot_[facet_[slot]] = slot;
  const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
  const Vec3 n = normalized(cross(b - a, c - a));
  const Point<Part> centre = ball_centre(a, b, c);
  const double radius = std::max({distance(centre, a), distance(centre, b), distance(centre, c)});
  placed_[slot] = {{a, b, c}, n, dot(n, from_origin(a)), centre, radius};
  const Vec3 from_middle = centre - middle_;
  balls_[0][slot] = static_cast<float>(from_middle.x), balls_[1][slot] = static_cast<float>(from_middle.y);
  balls_[2][slot] = static_cast<float>(from_middle.z), balls_[3][slot] = static_cast<float>(radius + spare_);
}

}  // namespace tiltfeed::pathgen
