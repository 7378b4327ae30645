#include "sim/collision/body_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "sim/solid/distance.h"

namespace tiltfeed::sim {
namespace {

constexpr std::uint32_t kLeaf = 2;
// A facet whose box is thicker across it than this, mm, or than this share of the body, is cut up: a leaning
// facet's box is near to much that the facet is far from.
constexpr double kThickest = 1.0, kThickestShare = 0.02;

Point<Part> at(Vec3 v) { return Point<Part>{} + v; }

Triangle moved(const Triangle& t, const Placement& pose) {
  Triangle m = t;
  m.a = at(pose(from_origin(t.a)));
  m.ab = pose.rotation * t.ab, m.ac = pose.rotation * t.ac, m.normal = pose.rotation * t.normal;
  m.grad_v = pose.rotation * t.grad_v, m.grad_w = pose.rotation * t.grad_w;
  return m;
}

/// All of `t` lies on one side of the plane of `of`, further than `distance`.
bool beyond_plane(const Triangle& of, const Triangle& t, double distance) {
  const double a = dot(of.normal, t.a - of.a), b = a + dot(of.normal, t.ab), c = a + dot(of.normal, t.ac);
  return std::min({a, b, c}) > distance || std::max({a, b, c}) < -distance;
}

/// The square of the distance of two triangles, or any value over that of `distance` where it is larger.
/// Edges with edges, corners with faces, edges through faces [the least of them is the distance of closed
/// triangles].
double squared_distance(const Triangle& a, const Triangle& b, double distance) {
  if (beyond_plane(a, b, distance) || beyond_plane(b, a, distance)) return kInfinity;
  double least = kInfinity;
  const std::array<Point<Part>, 3> of_a{a.a, a.a + a.ab, a.a + a.ac}, of_b{b.a, b.a + b.ab, b.a + b.ac};
  for (std::size_t i = 0; i < 3; ++i)
    least = std::min(least, squared_distance(a, Segment{of_b[i], of_b[(i + 1) % 3]}));
  Triangle face = b;
  face.owned = 0;  // its edges have met those of a
  for (std::size_t i = 0; i < 3; ++i)
    least = std::min(least, squared_distance(face, Segment{of_a[i], of_a[(i + 1) % 3]}));
  return least;
}

Vec3 positive(Vec3 v, Vec3 reach) {
  return {std::max(0.0, std::abs(v.x) - reach.x), std::max(0.0, std::abs(v.y) - reach.y),
          std::max(0.0, std::abs(v.z) - reach.z)};
}

Rotation absolute(const Rotation& r) {
  Rotation a;
  for (std::size_t i = 0; i < 3; ++i)
    a.rows[i] = {std::abs(r.rows[i].x), std::abs(r.rows[i].y), std::abs(r.rows[i].z)};
  return a;
}

}  // namespace

Placement operator*(const Placement& a, const Placement& b) {
  return {a.rotation * b.rotation, a.rotation * b.shift + a.shift};
}

Placement inverse(const Placement& a) {
  const Rotation back = transposed(a.rotation);
  return {back, -(back * a.shift)};
}

void BodyTree::add(const std::vector<Vec3>& vertices,
                   const std::vector<std::array<std::uint32_t, 3>>& facets) {
  const auto from = static_cast<std::uint32_t>(vertices_.size());
  vertices_.insert(vertices_.end(), vertices.begin(), vertices.end());
  for (const auto& [a, b, c] : facets) facets_.push_back({from + a, from + b, from + c});
}

void BodyTree::build() {
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (const Vec3 v : vertices_) low = lower(low, v), high = upper(high, v);
  const double thickest = std::max(kThickest, kThickestShare * length(high - low));
  for (std::uint32_t i = 0; i < facets_.size(); ++i) {
    const auto& [a, b, c] = facets_[i];
    cut_up({vertices_[a], vertices_[b], vertices_[c]}, i, thickest);
  }
  find_shells();
  std::vector<Key> keys(triangles_.size());
  for (std::uint32_t i = 0; i < keys.size(); ++i)
    keys[i] = {from_origin(triangles_[i].a) + (triangles_[i].ab + triangles_[i].ac) / 3.0, i};
  nodes_.reserve(keys.size());
  nodes_.resize(1);
  split(0, keys, 0);
  std::vector<Triangle> sorted;
  sorted.reserve(keys.size());
  for (const Key& key : keys) sorted.push_back(triangles_[key.triangle]);
  triangles_.swap(sorted);
}

/// Halved at its longest side.
void BodyTree::cut_up(const std::array<Vec3, 3>& corners, std::uint32_t facet, double thickest) {
  const auto& [a, b, c] = corners;
  const Triangle whole = make_triangle(at(a), at(b), at(c), facet);
  const Vec3 wide = upper(a, upper(b, c)) - lower(a, lower(b, c)), n = whole.normal;
  if (std::abs(n.x) * wide.x + std::abs(n.y) * wide.y + std::abs(n.z) * wide.z <= thickest) {
    triangles_.push_back(whole);
    return;
  }
  std::size_t k = 0;  // the longest side is from corner k to the next
  for (std::size_t i = 1; i < 3; ++i)
    if (squared_length(corners[(i + 1) % 3] - corners[i]) > squared_length(corners[(k + 1) % 3] - corners[k]))
      k = i;
  const Vec3 from = corners[k], to = corners[(k + 1) % 3], opposite = corners[(k + 2) % 3],
             middle = (from + to) * 0.5;
  cut_up({from, middle, opposite}, facet, thickest);
  cut_up({middle, to, opposite}, facet, thickest);
}

BodyTree::Node BodyTree::node_round(Vec3 low, Vec3 high, std::uint32_t first, std::uint32_t count) {
  const Vec3 half = (high - low) * 0.5;
  return {(low + high) * 0.5, half, length(half), first, count};
}

/// Halves the triangles of `keys` from begin to end at the middle of the axis along which they lie widest.
void BodyTree::split(std::uint32_t node, std::span<Key> keys, std::uint32_t begin) {
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
  const std::size_t count = keys.size();
  if (count <= kLeaf) {
    for (const Key& key : keys) {
      const Triangle& t = triangles_[key.triangle];
      for (const Vec3 corner : {Vec3{}, t.ab, t.ac}) {
        const Vec3 p = from_origin(t.a) + corner;
        low = lower(low, p), high = upper(high, p);
      }
    }
    nodes_[node] = node_round(low, high, begin, static_cast<std::uint32_t>(count));
    return;
  }
  for (const Key& key : keys) low = lower(low, key.middle), high = upper(high, key.middle);
  const Vec3 wide = high - low;
  const auto along = [&](const Key& key) {
    const Vec3 m = key.middle;
    return wide.x >= wide.y && wide.x >= wide.z ? m.x : wide.y >= wide.z ? m.y : m.z;
  };
  const auto half = static_cast<std::uint32_t>(count / 2);
  std::nth_element(keys.begin(), keys.begin() + half, keys.end(), [&](const Key& a, const Key& b) {
    const double x = along(a), y = along(b);
    return x != y ? x < y : a.triangle < b.triangle;
  });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  split(children, keys.first(half), begin);
  split(children + 1, keys.subspan(half), begin + half);
  const Node &x = nodes_[children], &y = nodes_[children + 1];
  low = lower(x.centre - x.half, y.centre - y.half), high = upper(x.centre + x.half, y.centre + y.half);
  nodes_[node] = node_round(low, high, children, 0);
}

/// Facets that share a corner are of one shell.
void BodyTree::find_shells() {
  std::vector<std::uint32_t> order(vertices_.size()), head(vertices_.size());
  std::iota(order.begin(), order.end(), 0U);
  std::iota(head.begin(), head.end(), 0U);
  const auto key = [&](std::uint32_t i) { return std::tie(vertices_[i].x, vertices_[i].y, vertices_[i].z); };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  const auto find = [&](std::uint32_t i) {
    while (head[i] != i) i = head[i] = head[head[i]];
    return i;
  };
  const auto join = [&](std::uint32_t a, std::uint32_t b) { head[find(a)] = find(b); };
  for (std::size_t i = 1; i < order.size(); ++i)
    if (key(order[i]) == key(order[i - 1])) join(order[i], order[i - 1]);
  for (const auto& [a, b, c] : facets_) join(a, b), join(b, c);
  std::vector<bool> seen(vertices_.size(), false);
  for (const auto& facet : facets_) {
    const std::uint32_t one = find(facet[0]);
    if (!seen[one]) shells_.push_back(vertices_[one]);
    seen[one] = true;
  }
}

/// (CO1) Two trees, the second standing at a pose.
struct BodyTree::Query {
  const BodyTree &a, &b;
  Placement pose;
  Rotation back, wide, wide_back;
  double bound, slack;
  bool first_will_do;
  std::optional<FacetPair> found{};
  std::uint32_t patience = 0;
  bool near = false;

  double apart(const Node& x, const Node& y, Vec3& between) const {
    between = pose(y.centre) - x.centre;
    const Vec3 one = positive(between, x.half + wide * y.half);
    const Vec3 two = positive(back * between, y.half + wide_back * x.half);
    return std::max(squared_length(one), squared_length(two));
  }
  bool done() const { return near || (found.has_value() && (first_will_do || found->distance == 0.0)); }

  void leaves(const Node& x, const Node& y) {
    for (std::uint32_t k = y.first; k < y.first + y.count; ++k) {
      const Triangle other = moved(b.triangles_[k], pose);
      for (std::uint32_t i = x.first; i < x.first + x.count; ++i) {
        const double square = squared_distance(a.triangles_[i], other, bound);
        if (square > bound * bound) continue;
        bound = std::sqrt(square);
        found = FacetPair{bound, a.triangles_[i].facet, other.facet};
        if (done()) return;
      }
    }
  }
  /// `middles`: the square of the distance of both boxes' middles.
  void visit(std::uint32_t i, std::uint32_t k, double middles) {
    const Node &x = a.nodes_[i], &y = b.nodes_[k];
    // Whatever is in them is at most so far apart.
    const double least = bound + slack - x.radius - y.radius;
    if (first_will_do && ((least > 0.0 && middles <= least * least) || (patience > 0 && --patience == 0))) {
      near = true;
      return;
    }
    if (x.count > 0 && y.count > 0) return leaves(x, y);
    const bool first = y.count > 0 || (x.count == 0 && squared_length(x.half) >= squared_length(y.half));
    struct Next {
      std::uint32_t i, k;
      double gap, middles;
    };
    std::array<Next, 2> next{};
    for (std::uint32_t child = 0; child < 2; ++child) {
      Next& n = next[child];
      n.i = first ? x.first + child : i, n.k = first ? k : y.first + child;
      Vec3 between;
      n.gap = apart(a.nodes_[n.i], b.nodes_[n.k], between);
      n.middles = squared_length(between);
    }
    if (std::tie(next[1].gap, next[1].middles) < std::tie(next[0].gap, next[0].middles))
      std::swap(next[0], next[1]);
    for (const Next& n : next)
      if (!done() && n.gap <= bound * bound) visit(n.i, n.k, n.middles);
  }
  void ask() {
    Vec3 between;
    if (apart(a.nodes_[0], b.nodes_[0], between) <= bound * bound) visit(0, 0, squared_length(between));
  }
};

bool BodyTree::nearer(const BodyTree& other, const Placement& pose, double distance, double slack,
                      std::uint32_t patience) const {
  const Rotation back = transposed(pose.rotation);
  Query query{*this, other, pose, back, absolute(pose.rotation), absolute(back), distance, slack, true};
  query.patience = patience;
  query.ask();
  return query.near || query.found.has_value();
}

std::optional<FacetPair> BodyTree::nearest(const BodyTree& other, const Placement& pose, double bound) const {
  const Rotation back = transposed(pose.rotation);
  Query query{*this, other, pose, back, absolute(pose.rotation), absolute(back), bound, 0.0, false};
  query.ask();
  return query.found;
}

/// Facets that the line from a point on crosses.
int BodyTree::crossings(Vec3 from, Vec3 along) const {
  int count = 0;
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const Node& node = nodes_[stack.back()];
    stack.pop_back();
    double enter = 0.0, leave = kInfinity;
    const auto clip = [&](double p, double v, double half) {
      const double near = (p - std::copysign(half, v)) / v, far = (p + std::copysign(half, v)) / v;
      enter = std::max(enter, near), leave = std::min(leave, far);
    };
    const Vec3 to = node.centre - from;
    clip(to.x, along.x, node.half.x), clip(to.y, along.y, node.half.y), clip(to.z, along.z, node.half.z);
    if (enter > leave) continue;
    if (node.count == 0) {
      stack.push_back(node.first), stack.push_back(node.first + 1);
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = triangles_[i];
      const double slope = dot(t.normal, along), height = dot(t.normal, from - from_origin(t.a));
      if (slope == 0.0 || -height / slope < 0.0) continue;
      const Vec3 hit = from + along * (-height / slope) - from_origin(t.a);
      const double v = dot(t.grad_v, hit), w = dot(t.grad_w, hit);
      if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) ++count;
    }
  }
  return count;
}

bool BodyTree::in_box(Vec3 p) const { return positive(p - nodes_[0].centre, nodes_[0].half) == Vec3{}; }

bool BodyTree::inside(Vec3 p) const {
  // Directions in which no drawing has edges: a line that meets one is outvoted.
  int odd = 0;
  for (const Vec3 along :
       {Vec3{0.3217, 0.5471, 0.7727}, Vec3{-0.7013, 0.2911, 0.6507}, Vec3{0.1733, -0.8219, -0.5426}})
    odd += crossings(p, along) % 2;
  return odd >= 2;
}

double BodyTree::distance(Vec3 p) const {
  double least = kInfinity;
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const Node& node = nodes_[stack.back()];
    stack.pop_back();
    if (squared_length(positive(p - node.centre, node.half)) >= least) continue;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      least = std::min(least, sim::squared_distance(triangles_[i], at(p)));
    if (node.count > 0) continue;
    const bool swap =
        squared_length(p - nodes_[node.first].centre) < squared_length(p - nodes_[node.first + 1].centre);
    stack.push_back(node.first + (swap ? 1 : 0)), stack.push_back(node.first + (swap ? 0 : 1));
  }
  return std::sqrt(least);
}

}  // namespace tiltfeed::sim
