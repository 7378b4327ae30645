// Edges of a facet list, against a plain map from pairs of vertices to facets; and the facets round vertices.

#include "pathgen/topology.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>
#include <vector>

namespace tiltfeed {
namespace {

/// Facets on few vertices, so that edges have one, two or more of them; with a fan round vertex `tip` that is
/// wider than what is sorted in place.
std::vector<Facet> random_facets(std::uint32_t vertices, std::uint32_t count, std::uint32_t tip,
                                 std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Facet> facets;
  while (facets.size() < count) {
    const auto any = [&] { return static_cast<std::uint32_t>(random() % vertices); };
    const Facet f{facets.size() % 5 == 0 ? tip : any(), any(), any()};
    if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) facets.push_back(f);
  }
  return facets;
}

/// low, high, facet, forward: of every half-edge, in that order.
using Halves = std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, bool>>;

/// By brute force; and how many half-edges each edge has, in the order of the edges.
Halves expected_halves(const std::vector<Facet>& facets, std::vector<std::size_t>& sizes) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::pair<std::uint32_t, bool>>> edges;
  for (std::uint32_t f = 0; f < facets.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = facets[f][k], to = facets[f][(k + 1) % 3];
      edges[std::minmax(from, to)].push_back({f, from < to});
    }
  Halves halves;
  for (const auto& [ends, sides] : edges) {
    sizes.push_back(sides.size());
    for (const auto& [facet, forward] : sides) halves.push_back({ends.first, ends.second, facet, forward});
  }
  return halves;
}

class Topology : public testing::TestWithParam<std::uint64_t> {
 protected:
  static constexpr std::uint32_t kVertices = 120;
  const std::vector<Facet> facets = random_facets(kVertices, 900, 7, GetParam());

  void expect_edges(const auto& each_edge) {
    std::vector<std::size_t> sizes, expected_sizes;
    Halves halves;
    each_edge([&](std::span<const HalfEdge> edge) {
      sizes.push_back(edge.size());
      for (const HalfEdge& h : edge) halves.push_back({h.low, h.high, h.facet, h.forward});
    });
    EXPECT_EQ(halves, expected_halves(facets, expected_sizes));
    EXPECT_EQ(sizes, expected_sizes);
  }
};

TEST_P(Topology, ATableListsEachEdgeWithItsFacets) {
  const EdgeTable table(facets, kVertices);
  expect_edges([&](const auto& visit) { table.each_edge(visit); });
}

TEST_P(Topology, FansListTheSameEdgesInBlocks) {
  const VertexFans fans(facets, kVertices);
  expect_edges([&](const auto& visit) {
    for (std::uint32_t v = 0; v < kVertices; v += 50)
      fans.each_edge(facets, v, std::min(v + 50, kVertices), visit);
  });
}

TEST_P(Topology, FansListTheFacetsRoundAVertex) {
  const VertexFans fans(facets, kVertices);
  for (std::uint32_t v = 0; v < kVertices; ++v) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t f = 0; f < facets.size(); ++f)
      if (std::find(facets[f].begin(), facets[f].end(), v) != facets[f].end()) expected.push_back(f);
    const auto fan = fans.of(v);
    EXPECT_EQ(std::vector<std::uint32_t>(fan.begin(), fan.end()), expected) << "vertex " << v;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Topology, testing::Range<std::uint64_t>(1, 9));

}  // namespace
}  // namespace tiltfeed
