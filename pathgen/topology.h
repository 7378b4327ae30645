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
  std::uint32_t facet;
  bool forward;
};

/// The half-edges of all facets, those of one edge side by side, in the order of (low, high, facet).
/// Requires: the three vertices of each facet differ.
class EdgeTable {
 public:
  EdgeTable(const std::vector<Facet>& facets, std::size_t vertices);

  /// Calls visit(std::span<const HalfEdge>) once for each edge.
  template <class Visit>
  void each_edge(Visit visit) const {
    for (std::size_t begin = 0, end = 0; begin < halves_.size(); begin = end) {
      while (end < halves_.size() && halves_[end].low == halves_[begin].low &&
             halves_[end].high == halves_[begin].high)
        ++end;
      visit(std::span(halves_).subspan(begin, end - begin));
    }
  }

 private:
  std::vector<HalfEdge> halves_;
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
Shells find_shells(const EdgeTable& edges, std::size_t facets);

/// Turns a facet over.
inline void turn_over(Facet& facet) { std::swap(facet[1], facet[2]); }

}  // namespace tiltfeed
