#pragma once
// Edges and shells of a facet list: who is whose neighbour.

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pathgen/mesh/fresh_memory.h"

namespace tiltfeed::pathgen {

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

/// The facets round each vertex, ascending, and from them the edges. The facets must stay where they are, but
/// may be turned over. Requires: the three vertices of each facet differ; below 2^31 facets.
class VertexFans {
 public:
  VertexFans() = default;
  VertexFans(const std::vector<Facet>& facets, std::size_t vertices);

  std::size_t vertices() const { return start_.size() - 1; }
  std::size_t facets() const { return facets_.size(); }
  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(entries_).subspan(start_[vertex], start_[vertex + 1] - start_[vertex]);
  }
  /// Calls visit(std::span<const HalfEdge>) once for each edge, in the order of (low, high); its half-edges
  /// in the order of their facets.
  template <class Visit>
  void each_edge(Visit visit) const {
    each_edge(0, vertices(), visit);
  }
  /// The same for the edges whose low is in [first, last): for work in blocks.
  template <class Visit>
  void each_edge(std::size_t first, std::size_t last, Visit visit) const {
    std::vector<HalfEdge> halves;
    for (std::size_t v = first; v < last; ++v) {
      gather(static_cast<std::uint32_t>(v), halves);
      each_edge_of(halves, visit);
    }
  }

 private:
  void gather(std::uint32_t vertex, std::vector<HalfEdge>& halves) const;

  std::span<const Facet> facets_;
  std::vector<std::uint32_t> start_{0};  ///< the facets of v are entries_[start_[v]] to start_[v + 1]
  FreshVector<std::uint32_t> entries_;
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
  FreshVector<std::uint32_t> of_facet;
  std::uint32_t count = 0;
};

/// What one look at all edges tells, for any number of threads the same.
struct EdgeSurvey {
  bool all_sound = true;             ///< each edge is kSound
  bool may_have_duplicates = false;  ///< false: no two facets have the same corners
  Shells shells;
};
EdgeSurvey survey(const VertexFans& fans);

/// Turns a facet over.
inline void turn_over(Facet& facet) { std::swap(facet[1], facet[2]); }

}  // namespace tiltfeed::pathgen
