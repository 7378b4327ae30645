#include "pathgen/topology.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <numeric>

namespace tiltfeed {
namespace {

using Range = tbb::blocked_range<std::size_t>;
using Counter = std::atomic_ref<std::uint32_t>;

/// Facets or vertices that one task takes at least: a few tens of microseconds of work.
constexpr std::size_t kGrain = 4096;
/// Vertices are dealt to this many tasks where each must read all facets.
constexpr std::size_t kParts = 4;
/// A vertex with more half-edges is the tip of a cone: sorted, and looked into, another way.
constexpr std::ptrdiff_t kManyHalves = 32;
constexpr std::uint32_t kFacetBits = 0x7FFFFFFF;
constexpr auto kRelaxed = std::memory_order_relaxed;

/// Union-find on facets; the root of a tree is its lowest facet, whoever joins first.
class Forest {
 public:
  explicit Forest(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::uint32_t root(std::uint32_t i) {
    for (;;) {
      std::uint32_t up = at(i).load(kRelaxed);
      if (up == i) return i;
      const std::uint32_t top = at(up).load(kRelaxed);
      if (top != up) at(i).compare_exchange_weak(up, top, kRelaxed);
      i = top;
    }
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

 private:
  Counter at(std::uint32_t i) { return Counter(parent_[i]); }
  std::vector<std::uint32_t> parent_;
};

/// Calls visit(low, high, facet, forward) for the half-edges whose low is in [first, last).
template <class Visit>
void each_half(const std::vector<Facet>& facets, std::uint32_t first, std::uint32_t last,
               const Visit& visit) {
  for (std::uint32_t i = 0; i < facets.size(); ++i) {
    const auto [a, b, c] = facets[i];
    const auto side = [&](std::uint32_t from, std::uint32_t to) {
      const std::uint32_t low = std::min(from, to);
      if (low - first < last - first) visit(low, std::max(from, to), i, from < to);
    };
    side(a, b), side(b, c), side(c, a);
  }
}

}  // namespace

EdgeTable::EdgeTable(const std::vector<Facet>& facets, std::size_t vertices)
    : start_(vertices + 1, 0), halves_(facets.size() * 3) {
  // A counting sort by the lower vertex. Each task reads all facets for its own vertices: cheaper than two
  // atomic counters for every half-edge, and in the order of the facets.
  const auto each_part = [&](const auto& work) {
    tbb::parallel_for(std::size_t{0}, kParts, [&](std::size_t part) {
      work(static_cast<std::uint32_t>(vertices * part / kParts),
           static_cast<std::uint32_t>(vertices * (part + 1) / kParts));
    });
  };
  each_part([&](std::uint32_t first, std::uint32_t last) {
    each_half(facets, first, last,
              [&](std::uint32_t low, std::uint32_t, std::uint32_t, bool) { ++start_[low]; });
  });
  std::exclusive_scan(start_.begin(), start_.end(), start_.begin(), 0U);
  each_part([&](std::uint32_t first, std::uint32_t last) { gather(facets, first, last); });

  struct Flags {
    bool sound = true, duplicates = false;
  };
  const Flags flags = tbb::parallel_reduce(
      Range(0, vertices, kGrain), Flags{},
      [&](const Range& range, Flags f) {
        for (std::size_t v = range.begin(); v < range.end(); ++v)
          judge(static_cast<std::uint32_t>(v), f.sound, f.duplicates);
        return f;
      },
      [](Flags a, Flags b) {
        return Flags{a.sound && b.sound, a.duplicates || b.duplicates};
      });
  all_sound_ = flags.sound;
  may_have_duplicates_ = flags.duplicates;
}

void EdgeTable::gather(const std::vector<Facet>& facets, std::uint32_t first, std::uint32_t last) {
  std::vector<std::uint32_t> next(start_.begin() + first, start_.begin() + last);
  each_half(facets, first, last,
            [&](std::uint32_t low, std::uint32_t high, std::uint32_t facet, bool forward) {
              halves_[next[low - first]++] = {low, high, facet & kFacetBits, forward};
            });
  // Short stable sorts within each vertex, six half-edges or so, which stand in the order of the facets.
  const auto before = [](const HalfEdge& a, const HalfEdge& b) { return a.high < b.high; };
  for (std::uint32_t v = first; v < last; ++v) {
    const auto begin = halves_.begin() + start_[v], end = halves_.begin() + start_[v + 1];
    if (end - begin > kManyHalves) {
      std::stable_sort(begin, end, before);
      continue;
    }
    for (auto at = begin; at < end; ++at)  // insertion
      std::rotate(std::upper_bound(begin, at, *at, before), at, at + 1);
  }
}

/// Two facets on the same corners share the two edges at their lowest one.
void EdgeTable::judge(std::uint32_t vertex, bool& sound, bool& duplicates) const {
  std::array<std::pair<std::uint32_t, std::uint32_t>, kManyHalves> pairs;
  std::size_t count = 0;
  each_edge(vertex, vertex + 1, [&](std::span<const HalfEdge> edge) {
    sound = sound && state(edge) == EdgeState::kSound;
    if (edge.size() == 1) return;
    const std::pair<std::uint32_t, std::uint32_t> pair{edge[0].facet, edge[1].facet};
    if (edge.size() > 2 || count == pairs.size() ||
        std::find(pairs.begin(), pairs.begin() + count, pair) != pairs.begin() + count)
      duplicates = true;
    else
      pairs[count++] = pair;
  });
}

Shells find_shells(const EdgeTable& edges, std::size_t facets) {
  Forest forest(facets);
  tbb::parallel_for(Range(0, edges.vertices(), kGrain), [&](const Range& range) {
    edges.each_edge(range.begin(), range.end(), [&](std::span<const HalfEdge> edge) {
      if (edge.size() == 2) forest.join(edge[0].facet, edge[1].facet);
    });
  });
  Shells shells;
  shells.of_facet.resize(facets);
  tbb::parallel_for(Range(0, facets, kGrain), [&](const Range& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      shells.of_facet[i] = forest.root(static_cast<std::uint32_t>(i));
  });
  for (std::uint32_t i = 0; i < facets; ++i) {
    std::uint32_t& shell = shells.of_facet[i];
    shell = shell == i ? shells.count++ : shells.of_facet[shell];
  }
  return shells;
}

}  // namespace tiltfeed
