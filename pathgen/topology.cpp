#include "pathgen/topology.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace tiltfeed {

EdgeTable::EdgeTable(const std::vector<Facet>& facets, std::size_t vertices) : halves_(facets.size() * 3) {
  // A counting sort by the lower vertex, then short sorts within each vertex: six half-edges or so.
  std::vector<std::uint32_t> end(vertices + 1, 0);
  for (const Facet& f : facets)
    for (int k = 0; k < 3; ++k) ++end[std::min(f[k], f[(k + 1) % 3]) + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  for (std::uint32_t i = 0; i < facets.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t from = facets[i][k], to = facets[i][(k + 1) % 3];
      halves_[end[std::min(from, to)]++] = {std::min(from, to), std::max(from, to), i, from < to};
    }
  }
  const auto before = [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.high, a.facet) < std::tie(b.high, b.facet);
  };
  std::size_t begin = 0;
  for (std::size_t v = 0; v < vertices; begin = end[v++])
    std::sort(halves_.begin() + begin, halves_.begin() + end[v], before);
}

Shells find_shells(const EdgeTable& edges, std::size_t facets) {
  // Union-find; the root of a tree is its lowest facet.
  std::vector<std::uint32_t> parent(facets);
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  edges.each_edge([&](std::span<const HalfEdge> edge) {
    if (edge.size() != 2) return;
    const std::uint32_t a = root(edge[0].facet), b = root(edge[1].facet);
    parent[std::max(a, b)] = std::min(a, b);
  });
  Shells shells;
  shells.of_facet.resize(facets);
  for (std::uint32_t i = 0; i < facets; ++i) {
    const std::uint32_t first = root(i);
    shells.of_facet[i] = first == i ? shells.count++ : shells.of_facet[first];
  }
  return shells;
}

}  // namespace tiltfeed
