#include "pathgen/mesh/topology.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>

#include "pathgen/mesh/tasks.h"

namespace tiltfeed::pathgen {
namespace {

using Range = tbb::blocked_range<std::size_t>;
using Counter = std::atomic_ref<std::uint32_t>;

/// Vertices are dealt to this many tasks at most where each must read all facets: no more than run at a time.
constexpr int kMostParts = 4;
/// A vertex with more half-edges is the tip of a cone: sorted, and looked into, another way.
constexpr std::ptrdiff_t kManyHalves = 32;
constexpr std::uint32_t kFacetBits = 0x7FFFFFFF;

/// Union-find on facets; the root of a tree is its lowest facet, whoever joins first.
class Forest {
 public:
  explicit Forest(std::size_t size) : parent_(size) {
    tbb::parallel_for(Range(0, size, kGrain), [&](const Range& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) parent_[i] = static_cast<std::uint32_t>(i);
    });
  }

  void join(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = root(a), b = root(b);
      if (a == b) return;
      if (a > b) std::swap(a, b);
      std::uint32_t alone = b;
      if (at(b).compare_exchange_strong(alone, a, kRelaxed)) return;
    }
  }
  /// The trees, by their lowest facets.
  Shells shells() {
    Shells shells;
    shells.of_facet.resize(parent_.size());
    tbb::parallel_for(Range(0, parent_.size(), kGrain), [&](const Range& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i)
        shells.of_facet[i] = root(static_cast<std::uint32_t>(i));
    });
    for (std::uint32_t i = 0; i < shells.of_facet.size(); ++i) {
      std::uint32_t& shell = shells.of_facet[i];
      shell = shell == i ? shells.count++ : shells.of_facet[shell];
    }
    return shells;
  }

 private:
  std::uint32_t root(std::uint32_t i) {
    for (;;) {
      std::uint32_t up = at(i).load(kRelaxed);
      if (up == i) return i;
      const std::uint32_t top = at(up).load(kRelaxed);
      if (top != up) at(i).compare_exchange_weak(up, top, kRelaxed);
      i = top;
    }
  }
  Counter at(std::uint32_t i) { return Counter(parent_[i]); }
  FreshVector<std::uint32_t> parent_;
};

/// Two facets on the same corners share the two edges at their lowest one: the pairs of facets on the edges
/// of one low vertex.
class PairsAtVertex {
 public:
  /// Takes the next edge; true if it, or the one vertex it stands at, leaves room for two such facets.
  bool has_twice(std::span<const HalfEdge> edge) {
    if (edge[0].low != low_) low_ = edge[0].low, count_ = 0;
    if (edge.size() == 1) return false;
    const std::pair<std::uint32_t, std::uint32_t> pair{edge[0].facet, edge[1].facet};
    if (edge.size() > 2 || count_ == kManyHalves ||
        std::find(pairs_.begin(), pairs_.begin() + count_, pair) != pairs_.begin() + count_)
      return true;
    pairs_[count_++] = pair;
    return false;
  }

 private:
  std::array<std::pair<std::uint32_t, std::uint32_t>, kManyHalves> pairs_;
  std::ptrdiff_t count_ = 0;
  std::uint32_t low_ = 0;
};

/// Calls work(first, last) for parts of the vertices, side by side. Each task may read all facets for its own
/// vertices: cheaper than atomic counters for every corner, and in the order of the facets.
template <class Work>
void each_part(std::size_t vertices, const Work& work) {
  const auto parts =
      static_cast<std::size_t>(std::clamp(tbb::this_task_arena::max_concurrency(), 1, kMostParts));
  tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
    work(static_cast<std::uint32_t>(vertices * part / parts),
         static_cast<std::uint32_t>(vertices * (part + 1) / parts));
  });
}

/// Sorts the half-edges of one low vertex, six or so, which stand in the order of the facets.
template <class Iterator>
void sort_by_high(Iterator begin, Iterator end) {
  const auto before = [](const HalfEdge& a, const HalfEdge& b) { return a.high < b.high; };
  if (end - begin > kManyHalves) {
    std::stable_sort(begin, end, before);
    return;
  }
  for (auto at = begin; at < end; ++at) {  // insertion
    const HalfEdge half = *at;
    auto to = at;
    for (; to > begin && before(half, *(to - 1)); --to) *to = *(to - 1);
    *to = half;
  }
}

}  // namespace

VertexFans::VertexFans(const std::vector<Facet>& facets, std::size_t vertices)
    : facets_(facets), start_(vertices + 1, 0), entries_(facets.size() * 3) {
  // A counting sort by the vertex.
  const auto each_corner = [&](std::uint32_t first, std::uint32_t last, const auto& visit) {
    for (std::uint32_t f = 0; f < facets.size(); ++f)
      for (std::uint32_t v : facets[f])
        if (v - first < last - first) visit(v, f);
  };
  each_part(vertices, [&](std::uint32_t first, std::uint32_t last) {
    each_corner(first, last, [&](std::uint32_t v, std::uint32_t) { ++start_[v]; });
  });
  std::exclusive_scan(start_.begin(), start_.end(), start_.begin(), 0U);
  each_part(vertices, [&](std::uint32_t first, std::uint32_t last) {
    std::vector<std::uint32_t> next(start_.begin() + first, start_.begin() + last);
    each_corner(first, last, [&](std::uint32_t v, std::uint32_t f) { entries_[next[v - first]++] = f; });
  });
}

/// The half-edges with this low vertex, sorted.
void VertexFans::gather(std::uint32_t vertex, std::vector<HalfEdge>& halves) const {
  halves.clear();
  for (std::uint32_t f : of(vertex)) {
    const Facet& corner = facets_[f];
    const std::size_t k = corner[0] == vertex ? 0 : corner[1] == vertex ? 1 : 2;
    const std::uint32_t next = corner[(k + 1) % 3], before = corner[(k + 2) % 3];
    if (next > vertex) halves.push_back({vertex, next, f & kFacetBits, true});
    if (before > vertex) halves.push_back({vertex, before, f & kFacetBits, false});
  }
  sort_by_high(halves.begin(), halves.end());
}

EdgeSurvey survey(const VertexFans& fans) {
  struct Flags {
    bool sound = true, duplicates = false;
  };
  Forest forest(fans.facets());
  const Flags flags = tbb::parallel_reduce(
      Range(0, fans.vertices(), kGrain), Flags{},
      [&](const Range& range, Flags f) {
        PairsAtVertex pairs;
        fans.each_edge(range.begin(), range.end(), [&](std::span<const HalfEdge> edge) {
          f.sound = f.sound && state(edge) == EdgeState::kSound;
          f.duplicates = f.duplicates || pairs.has_twice(edge);
          if (edge.size() == 2) forest.join(edge[0].facet, edge[1].facet);
        });
        return f;
      },
      [](Flags a, Flags b) {
        return Flags{a.sound && b.sound, a.duplicates || b.duplicates};
      });
  return {flags.sound, flags.duplicates, forest.shells()};
}

}  // namespace tiltfeed::pathgen
