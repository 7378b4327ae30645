#pragma once
// The sides of a mesh's facets, edge by edge. (pathgen/mesh/topology.h is the planner's: what judges has its
// own.)

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

namespace tiltfeed::sim {

/// Side `side` of a facet, from its corner of that number to the next one; low < high are its vertices.
struct HalfEdge {
  std::uint32_t low, high, facet, side;
};

/// Those of all facets in the order of (low, high, facet, side): in bins by their low vertex, where few meet.
inline std::vector<HalfEdge> half_edges(const std::vector<std::array<std::uint32_t, 3>>& facets,
                                        std::size_t vertices) {
  const auto of = [&](std::uint32_t facet, std::uint32_t side) {
    const std::uint32_t a = facets[facet][side], b = facets[facet][(side + 1) % 3];
    return HalfEdge{std::min(a, b), std::max(a, b), facet, side};
  };
  std::vector<std::uint32_t> end(vertices + 1, 0);  // of each bin; while it is filled, of what is in it
  for (const auto& facet : facets)
    for (std::size_t side = 0; side < 3; ++side) ++end[std::min(facet[side], facet[(side + 1) % 3]) + 1];
  for (std::size_t v = 0; v < vertices; ++v) end[v + 1] += end[v];
  std::vector<HalfEdge> halves(facets.size() * 3);
  for (std::uint32_t facet = 0; facet < facets.size(); ++facet) {
    for (std::uint32_t side = 0; side < 3; ++side) {
      const HalfEdge half = of(facet, side);
      halves[end[half.low]++] = half;
    }
  }
  std::uint32_t begin = 0;
  for (std::size_t v = 0; v < vertices; begin = end[v++])
    std::sort(halves.begin() + begin, halves.begin() + end[v], [](const HalfEdge& a, const HalfEdge& b) {
      return std::tie(a.high, a.facet, a.side) < std::tie(b.high, b.facet, b.side);
    });
  return halves;
}

}  // namespace tiltfeed::sim
