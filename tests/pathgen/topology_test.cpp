// Edges of a facet list, against a plain map from pairs of vertices to facets; and the facets round vertices.

#include "pathgen/mesh/topology.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <random>
#include <tuple>
#include <vector>

namespace tiltfeed {
using namespace pathgen;
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

TEST_P(Topology, FansListEachEdgeWithItsFacets) {
  const VertexFans fans(facets, kVertices);
  expect_edges([&](const auto& visit) { fans.each_edge(visit); });
}

TEST_P(Topology, FansListTheSameEdgesInBlocks) {
  const VertexFans fans(facets, kVertices);
  expect_edges([&](const auto& visit) {
    for (std::uint32_t v = 0; v < kVertices; v += 50) fans.each_edge(v, std::min(v + 50, kVertices), visit);
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

/// Joins across edges of two facets until nothing changes; of each facet the lowest of its shell.
std::vector<std::uint32_t> lowest_of_shell(const std::vector<Facet>& facets) {
  std::vector<std::size_t> sizes;
  const Halves halves = expected_halves(facets, sizes);
  std::vector<std::uint32_t> lowest(facets.size());
  std::iota(lowest.begin(), lowest.end(), 0U);
  for (bool changed = true; changed;) {
    changed = false;
    auto half = halves.begin();
    for (std::size_t size : sizes) {
      std::uint32_t &a = lowest[std::get<2>(half[0])], &b = lowest[std::get<2>(half[size - 1])];
      if (size == 2 && a != b) a = b = std::min(a, b), changed = true;
      half += static_cast<std::ptrdiff_t>(size);
    }
  }
  return lowest;
}

TEST_P(Topology, ASurveyTellsShells) {
  // Sparse facets of which few hang together, then ever more.
  for (const std::uint32_t count : {40U, 120U, 300U, 900U}) {
    const std::vector<Facet> some(facets.begin(), facets.begin() + count);
    const std::vector<std::uint32_t> lowest = lowest_of_shell(some);
    const Shells shells = survey(VertexFans(some, kVertices)).shells;
    std::vector<std::uint32_t> first;  // facet of each shell
    for (std::uint32_t f = 0; f < count; ++f) {
      if (lowest[f] == f) first.push_back(f);
      ASSERT_LT(shells.of_facet[f], first.size());
      EXPECT_EQ(first[shells.of_facet[f]], lowest[f]) << "facet " << f << " of " << count;
    }
    EXPECT_EQ(shells.count, first.size());
  }
}

TEST_P(Topology, ASurveyTellsWhetherAllIsSound) {
  // Tetrahedra, each on its own.
  std::vector<Facet> closed;
  for (std::uint32_t v = 0; v < kVertices; v += 4)
    closed.insert(closed.end(),
                  {{v, v + 1, v + 2}, {v, v + 2, v + 3}, {v, v + 3, v + 1}, {v + 1, v + 3, v + 2}});
  const auto look = [](const std::vector<Facet>& f) { return survey(VertexFans(f, kVertices)); };
  EXPECT_TRUE(look(closed).all_sound);
  EXPECT_FALSE(look(closed).may_have_duplicates);
  const std::size_t one = GetParam() * 7 % closed.size();
  std::vector<Facet> turned = closed, open = closed, twice = closed;
  turn_over(turned[one]);
  EXPECT_FALSE(look(turned).all_sound);
  EXPECT_FALSE(look(turned).may_have_duplicates);
  open.erase(open.begin() + static_cast<std::ptrdiff_t>(one));
  EXPECT_FALSE(look(open).all_sound);
  EXPECT_FALSE(look(open).may_have_duplicates);
  twice.push_back(closed[one]), turn_over(twice.back());
  EXPECT_FALSE(look(twice).all_sound);
  EXPECT_TRUE(look(twice).may_have_duplicates);
  // Two facets back to back have sound edges.
  EXPECT_TRUE(look({{0, 1, 2}, {0, 2, 1}}).all_sound);
  EXPECT_TRUE(look({{0, 1, 2}, {0, 2, 1}}).may_have_duplicates);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Topology, testing::Range<std::uint64_t>(1, 9));

}  // namespace
}  // namespace tiltfeed
