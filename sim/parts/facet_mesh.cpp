#include "sim/parts/facet_mesh.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <queue>
#include <tuple>
#include <utility>

namespace tiltfeed::sim {
namespace {

double squared_distance(const FacetMesh& mesh, std::uint32_t a, std::uint32_t b) {
  return squared_length(mesh.vertices[a] - mesh.vertices[b]);
}

/// Coordinates are multiples of this before they become float32: what should be 0 is 0, whatever the last
/// bits of a sine are on this machine.
constexpr double kGrid = 1.0 / (1 << 20);

/// To the 24 bits of a float32's significand, by splitting [Dekker 1971]: GCC 12 at -O2 can vectorise away a
/// cast to float and back.
double rounded(double value) {
  constexpr double kSplit = (1 << 29) + 1;
  const double on_grid = std::round(value / kGrid) * kGrid;
  const double scaled = on_grid * kSplit;
  return scaled - (scaled - on_grid) + 0.0;
}

/// Half-edge 3 f + i runs from corner i of facet f to its next corner.
class EdgeSplitter {
 public:
  EdgeSplitter(FacetMesh& mesh, const Midpoint& midpoint) : mesh_(mesh), midpoint_(midpoint) {
    pair_half_edges();
  }

  void split_longest() {
    while (!is_current(queue_.top())) queue_.pop();
    const std::uint32_t half = queue_.top().half;
    queue_.pop();
    split(half);
  }

 private:
  struct Edge {
    double squared_length;
    std::uint32_t low, high, half;
    bool operator<(const Edge& other) const {
      return std::tie(squared_length, other.low, other.high) < std::tie(other.squared_length, low, high);
    }
  };

  std::uint32_t from(std::uint32_t half) const { return mesh_.facets[half / 3][half % 3]; }
  static std::uint32_t next(std::uint32_t half) { return half - half % 3 + (half + 1) % 3; }
  std::uint32_t to(std::uint32_t half) const { return from(next(half)); }

  Edge edge(std::uint32_t half) const {
    const std::uint32_t low = std::min(from(half), to(half)), high = std::max(from(half), to(half));
    return {squared_distance(mesh_, low, high), low, high, half};
  }

  /// An edge that was split, or whose half-edge now names another edge, has stale entries in the queue.
  bool is_current(const Edge& queued) const {
    const std::uint32_t a = from(queued.half), b = to(queued.half);
    return std::min(a, b) == queued.low && std::max(a, b) == queued.high;
  }

  void pair_half_edges() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> by_ends;  // (low, high) in one number, half-edge
    by_ends.reserve(3 * mesh_.facets.size());
    for (std::uint32_t half = 0; half < 3 * mesh_.facets.size(); ++half) {
      const std::uint64_t a = from(half), b = to(half);
      by_ends.emplace_back(std::min(a, b) << 32 | std::max(a, b), half);
    }
    std::sort(by_ends.begin(), by_ends.end());
    opposite_.resize(by_ends.size());
    std::vector<Edge> edges;
    edges.reserve(by_ends.size() / 2);
    for (std::size_t i = 0; i + 1 < by_ends.size(); i += 2) {
      const std::uint32_t half = by_ends[i].second, other = by_ends[i + 1].second;
      assert(from(half) == to(other) && to(half) == from(other));
      join(half, other);
      edges.push_back(edge(half));
    }
    queue_ = std::priority_queue<Edge>(std::less<Edge>(), std::move(edges));
  }

  void join(std::uint32_t a, std::uint32_t b) {
    opposite_[a] = b;
    opposite_[b] = a;
  }

  void split(std::uint32_t half) {
    const std::uint32_t twin = opposite_[half];
    const std::uint32_t a = from(half), b = to(half), c = to(next(half)), d = to(next(twin));
    const std::uint32_t beyond_bc = opposite_[next(half)], beyond_ad = opposite_[next(twin)];
    const std::uint32_t m = add_vertex(mesh_, midpoint_(a, b));
    const auto first_new = static_cast<std::uint32_t>(3 * mesh_.facets.size());
    const std::uint32_t second_new = first_new + 3;
    mesh_.facets[half / 3][next(half) % 3] = m;  // a m c
    mesh_.facets[twin / 3][next(twin) % 3] = m;  // b m d
    mesh_.facets.push_back({m, b, c});
    mesh_.facets.push_back({m, a, d});
    opposite_.resize(opposite_.size() + 6);
    join(half, second_new);
    join(twin, first_new);
    join(next(half), first_new + 2);
    join(next(twin), second_new + 2);
    join(first_new + 1, beyond_bc);
    join(second_new + 1, beyond_ad);
    for (const std::uint32_t changed : {half, twin, next(half), next(twin), first_new + 1, second_new + 1})
      queue_.push(edge(changed));
  }

  FacetMesh& mesh_;
  const Midpoint& midpoint_;
  std::vector<std::uint32_t> opposite_;
  std::priority_queue<Edge> queue_;
};

}  // namespace

std::uint32_t add_vertex(FacetMesh& mesh, Vec3 position) {
  mesh.vertices.push_back({rounded(position.x), rounded(position.y), rounded(position.z)});
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void add_quad(FacetMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  if (squared_distance(mesh, a, c) <= squared_distance(mesh, b, d)) {
    mesh.facets.push_back({a, b, c});
    mesh.facets.push_back({a, c, d});
  } else {
    mesh.facets.push_back({a, b, d});
    mesh.facets.push_back({b, c, d});
  }
}

void split_longest_edges(FacetMesh& mesh, std::size_t facet_count, const Midpoint& midpoint) {
  assert(facet_count >= mesh.facets.size() && (facet_count - mesh.facets.size()) % 2 == 0);
  mesh.facets.reserve(facet_count);
  EdgeSplitter splitter(mesh, midpoint);
  while (mesh.facets.size() < facet_count) splitter.split_longest();
}

Vec3 straight_midpoint(const FacetMesh& mesh, std::uint32_t a, std::uint32_t b) {
  return from_origin(lerp(mesh.vertices[a], mesh.vertices[b], 0.5));
}

Triangles to_triangles(const FacetMesh& mesh) {
  Triangles triangles;
  triangles.reserve(mesh.facets.size());
  for (const auto& [a, b, c] : mesh.facets)
    triangles.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
  return triangles;
}

}  // namespace tiltfeed::sim
