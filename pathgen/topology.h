#pragma once
// Edges and shells of a facet list: who is whose neighbour.

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tiltfeed {

using Facet = std::array<std::uint32_t, 3>;

/// One facet's side of the edge {low, high}, low < high; forward: the facet runs from low to high.
struct HalfEdge {
  std::uint32_t low, high;
  std::uint32_t facet : 31, forward : 1;
};

/// Calls visit(std::span<const HalfEdge>) for each edge. Requires: the half-edges of one edge are side by
/// side.
template <class Visit>
void each_edge_of(std::span<const HalfEdge> halves, Visit& visit) {
  for (std::size_t begin = 0, end = 0; begin < halves.size(); begin = end) {
    while (end < halves.size() && halves[end].low == halves[begin].low &&
           halves[end].high == halves[begin].high)
      ++end;
    visit(halves.subspan(begin, end - begin));
  }
}

/// The half-edges of all facets, those of one edge side by side, in the order of (low, high, facet).
/// Requires: the three vertices of each facet differ; below 2^31 facets.
class EdgeTable {
 public:
  EdgeTable() = default;
  EdgeTable(const std::vector<Facet>& facets, std::size_t vertices);

  /// Calls visit(std::span<const HalfEdge>) once for each edge.
  template <class Visit>
  void each_edge(Visit visit) const {
    each_edge(0, vertices(), visit);
  }
  /// The same for the edges whose low is in [first, last): for work in blocks.
  template <class Visit>
  void each_edge(std::size_t first, std::size_t last, Visit visit) const {
    each_edge_of(std::span(halves_).subspan(start_[first], start_[last] - start_[first]), visit);
  }
  std::size_t vertices() const { return start_.size() - 1; }

  /// Each edge has two facets, which run along it in opposite directions.
  bool all_sound() const { return all_sound_; }
  /// False: no two facets have the same corners.
  bool may_have_duplicates() const { return may_have_duplicates_; }

 private:
  void gather(const std::vector<Facet>& facets, std::uint32_t first, std::uint32_t last);
  void judge(std::uint32_t vertex, bool& sound, bool& duplicates) const;

  std::vector<std::uint32_t> start_{0};  ///< the half-edges of low v are start_[v] to start_[v + 1]
  std::vector<HalfEdge> halves_;
  bool all_sound_ = true, may_have_duplicates_ = false;
};

/// The facets round each vertex, ascending, and from them the edges.
class VertexFans {
 public:
  VertexFans() = default;
  VertexFans(const std::vector<Facet>& facets, std::size_t vertices);

  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(facets_).subspan(start_[vertex], start_[vertex + 1] - start_[vertex]);
  }
  /// As EdgeTable::each_edge(), of the same facets: for those who ask once, without a table's memory.
  template <class Visit>
  void each_edge(const std::vector<Facet>& facets, std::uint32_t first, std::uint32_t last,
                 Visit visit) const {
    std::vector<HalfEdge> halves;
    for (std::uint32_t v = first; v < last; ++v) {
      gather(facets, v, halves);
      each_edge_of(halves, visit);
    }
  }

 private:
  void gather(const std::vector<Facet>& facets, std::uint32_t vertex, std::vector<HalfEdge>& halves) const;

  std::vector<std::uint32_t> start_{0};  ///< the facets of v are start_[v] to start_[v + 1]
  std::vector<std::uint32_t> facets_;
};

/// What an edge with these half-edges is.
enum class EdgeState { kSound, kOpen, kNonManifold, kMisoriented };
inline EdgeState state(std::span<const HalfEdge> edge) {
  if (edge.size() == 1) return EdgeState::kOpen;
  if (edge.size() > 2) return EdgeState::kNonManifold;
  return edge[0].forward == edge[1].forward ? EdgeState::kMisoriented : EdgeState::kSound;
}

/// Facets that hang together over edges with exactly two facets; shells count in the order of their first
/// facet.
struct Shells {
  std::vector<std::uint32_t> of_facet;
  std::uint32_t count = 0;
};
/// For any number of threads the same.
Shells find_shells(const EdgeTable& edges, std::size_t facets);

/// Turns a facet over.
inline void turn_over(Facet& facet) { std::swap(facet[1], facet[2]); }

}  // namespace tiltfeed
