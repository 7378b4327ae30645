#include "pathgen/mesh/weld.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <numeric>
#include <span>
#include <utility>

#include "pathgen/mesh/fresh_memory.h"
#include "pathgen/mesh/tasks.h"

namespace tiltfeed::pathgen {
namespace {

using Range = tbb::blocked_range<std::size_t>;

constexpr std::uint32_t kNone = 0xFFFFFFFF;

std::uint64_t hash(Point<Part> p) {
  // Multiply and fold after each coordinate [Steele 2014: the finalizer of SplitMix64]; float32 values leave
  // the low bits of a double empty, so the high bits must reach the low ones.
  std::uint64_t h = 0;
  for (double c : {p.x, p.y, p.z}) {
    h = (h ^ std::bit_cast<std::uint64_t>(c)) * 0xBF58476D1CE4E5B9ull;
    h ^= h >> 31;
  }
  h *= 0x94D049BB133111EBull;
  return h ^ (h >> 31);
}

/// The vertices and facets of an STL: an open table from points to the first corner that has them, filled by
/// all threads at once. Corner 3 f + k is corner k of facet f.
class CornerIndex {
 public:
  explicit CornerIndex(const Stl& stl)
      : stl_(stl), table_(std::bit_ceil(stl.facets.size() * 4 + 16)), slot_(stl.facets.size() * 3) {
    tbb::parallel_for(Range(0, table_.size(), kGrain), [&](const Range& range) {
      std::fill(table_.begin() + range.begin(), table_.begin() + range.end(), kNone);
    });
  }

  /// Vertices by first use; facets as in the file.
  Mesh mesh() {
    const std::size_t facets = stl_.facets.size(), blocks = (facets + kGrain - 1) / kGrain;
    tbb::parallel_for(Range(0, slot_.size(), kGrain), [&](const Range& range) {
      for (std::size_t c = range.begin(); c < range.end(); c += kAhead)
        enter(c, std::min(range.end(), c + kAhead));
    });
    // Vertices before each block, then their numbers, which replace the corners in the table.
    std::vector<std::uint32_t> start(blocks + 1, 0);
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) { start[b + 1] = number_firsts(b, {}, 0); });
    std::partial_sum(start.begin(), start.end(), start.begin());
    Mesh out;
    resize_side_by_side(out.vertices, start.back());
    resize_side_by_side(out.facets, facets);
    resize_side_by_side(out.source, facets);
    tbb::parallel_for(std::size_t{0}, blocks,
                      [&](std::size_t b) { number_firsts(b, out.vertices, start[b]); });
    tbb::parallel_for(Range(0, facets, kGrain), [&](const Range& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) out.facets[i][k] = table_[slot_[3 * i + k]] & ~kNumbered;
        out.source[i] = static_cast<std::uint32_t>(i);
      }
    });
    return out;
  }

 private:
  /// Marks a vertex number; corners stay below it (kMaxFacets).
  static constexpr std::uint32_t kNumbered = 0x80000000;
  /// Corners whose slots are fetched at a time: more than a core has loads in flight, few for its cache.
  static constexpr std::size_t kAhead = 64;
  using Slot = std::atomic_ref<std::uint32_t>;

  Point<Part> point(std::uint32_t corner) const {
    const Point<Part>& p = stl_.facets[corner / 3][corner % 3];
    return {p.x + 0.0, p.y + 0.0, p.z + 0.0};  // -0 becomes 0
  }

  /// Enters a run of corners; what their places in the table hold is fetched ahead, all at a time.
  void enter(std::size_t begin, std::size_t end) {
    const std::size_t mask = table_.size() - 1;
    for (std::size_t c = begin; c < end; ++c) {
      slot_[c] = static_cast<std::uint32_t>(hash(point(static_cast<std::uint32_t>(c))) & mask);
      __builtin_prefetch(&table_[slot_[c]]);
    }
    for (std::size_t c = begin; c < end; ++c) {
      const std::uint32_t seen = Slot(table_[slot_[c]]).load(kRelaxed);
      if (seen != kNone) __builtin_prefetch(&stl_.facets[seen / 3][seen % 3]);
    }
    for (std::size_t c = begin; c < end; ++c) slot_[c] = find_slot(static_cast<std::uint32_t>(c), slot_[c]);
  }

  /// Whoever comes first takes a slot; the lowest of the corners at its point ends there.
  std::uint32_t find_slot(std::uint32_t corner, std::uint32_t at) {
    const Point<Part> p = point(corner);
    const std::size_t mask = table_.size() - 1;
    for (;; at = static_cast<std::uint32_t>((at + 1) & mask)) {
      Slot slot(table_[at]);
      std::uint32_t seen = slot.load(kRelaxed);
      const bool taken = seen == kNone && slot.compare_exchange_strong(seen, corner, kRelaxed);
      if (!taken && point(seen) != p) continue;
      while (!taken && corner < seen && !slot.compare_exchange_weak(seen, corner, kRelaxed)) {
      }
      return at;
    }
  }

  /// Counts the first corners in a block of facets and, where there are vertices to fill, numbers them.
  std::uint32_t number_firsts(std::size_t block, std::span<Point<Part>> vertices, std::uint32_t start) {
    std::uint32_t next = start;
    const std::size_t end = std::min(slot_.size(), 3 * kGrain * (block + 1));
    for (std::size_t c = 3 * kGrain * block; c < end; ++c) {
      Slot slot(table_[slot_[c]]);
      if (slot.load(kRelaxed) != c) continue;
      if (!vertices.empty()) {
        vertices[next] = point(static_cast<std::uint32_t>(c));
        slot.store(next | kNumbered, kRelaxed);
      }
      ++next;
    }
    return next - start;
  }

  const Stl& stl_;
  FreshVector<std::uint32_t> table_, slot_;
};

/// The facets that pass the test, ascending.
template <class Test>
std::vector<std::uint32_t> facets_where(const Mesh& mesh, const Test& test) {
  using List = std::vector<std::uint32_t>;
  return tbb::parallel_reduce(
      Range(0, mesh.facets.size(), kGrain), List{},
      [&](const Range& range, List found) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
          if (test(mesh.facets[i])) found.push_back(static_cast<std::uint32_t>(i));
        return found;
      },
      [](List a, const List& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
}

void note(Found& found, const Mesh& mesh, const std::vector<std::uint32_t>& facets) {
  if (facets.empty()) return;
  const std::uint32_t first = mesh.source[facets[0]];  // sources ascend
  found.first = found.count == 0 ? first : std::min(found.first, first);
  found.count += facets.size();
}

/// Of the facets without area (ascending), those that seam: facets that hang together, all of whose edges
/// have two facets.
std::vector<std::uint32_t> find_seams(const Mesh& mesh, const VertexFans& fans,
                                      const std::vector<std::uint32_t>& thin) {
  std::vector<bool> is_thin(mesh.facets.size(), false);
  for (std::uint32_t i : thin) is_thin[i] = true;

  // Groups of thin facets that share an edge, whatever else is on it; the root is the lowest facet.
  std::vector<std::uint32_t> parent(mesh.facets.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<bool> seams(mesh.facets.size(), true);  // of a root: its group still may seam
  std::vector<std::uint32_t> torn;                    // facets on an edge that has not two facets
  fans.each_edge([&](std::span<const HalfEdge> edge) {
    std::uint32_t first = kNone;
    for (const HalfEdge& half : edge) {
      if (!is_thin[half.facet]) continue;
      if (first == kNone) first = half.facet;
      const std::uint32_t a = root(first), b = root(half.facet);
      parent[std::max(a, b)] = std::min(a, b);
    }
    if (first != kNone && edge.size() != 2) torn.push_back(first);
  });
  for (std::uint32_t i : torn) seams[root(i)] = false;
  std::vector<std::uint32_t> found;
  for (std::uint32_t i : thin)
    if (seams[root(i)]) found.push_back(i);
  return found;
}

/// Of the welding, what is done when corners are one and when the edges are known.
constexpr double kIndexed = 0.4, kSurveyed = 0.8;

}  // namespace

Welded weld(const Stl& stl, const ReportShare& report) {
  Welded out;
  Mesh& mesh = out.mesh = CornerIndex(stl).mesh();
  if (report) report(kIndexed);
  bool changed = true;  // since the last look at the edges
  const auto drop = [&](const std::vector<std::uint32_t>& facets) {
    if (!facets.empty()) remove_facets(mesh, facets), changed = true;
  };
  const auto name_and_drop = [&](Found& found, const std::vector<std::uint32_t>& facets) {
    note(found, mesh, facets), drop(facets);
  };
  const auto look = [&] {
    if (!std::exchange(changed, false)) return;
    out.fans = VertexFans(mesh.facets, mesh.vertices.size());
    out.survey = survey(out.fans);
  };
  const auto is_collapsed = [](const Facet& f) { return f[0] == f[1] || f[1] == f[2] || f[2] == f[0]; };
  name_and_drop(out.degenerate, facets_where(mesh, is_collapsed));
  look();
  if (report) report(kSurveyed);
  if (out.survey.may_have_duplicates) name_and_drop(out.duplicate, find_duplicates(mesh));
  const std::vector<std::uint32_t> thin = without_area(mesh);
  note(out.degenerate, mesh, thin);
  if (!thin.empty()) {
    look();
    const std::vector<std::uint32_t> seams = find_seams(mesh, out.fans, thin);
    std::vector<std::uint32_t> dropped;
    std::set_difference(thin.begin(), thin.end(), seams.begin(), seams.end(), std::back_inserter(dropped));
    for (std::uint32_t i : seams) {
      const auto before = std::lower_bound(dropped.begin(), dropped.end(), i) - dropped.begin();
      out.seams.push_back(i - static_cast<std::uint32_t>(before));
    }
    drop(dropped);
  }
  look();
  return out;
}

std::vector<std::uint32_t> find_duplicates(const Mesh& mesh) {
  // A counting sort by the lowest vertex, then short sorts within each vertex.
  struct Entry {
    std::uint32_t middle, high, facet;
    auto operator<=>(const Entry&) const = default;
  };
  std::vector<std::uint32_t> end(mesh.vertices.size() + 1, 0);
  for (const Facet& f : mesh.facets) ++end[std::min({f[0], f[1], f[2]}) + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Entry> entries(mesh.facets.size());
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    Facet f = mesh.facets[i];
    std::sort(f.begin(), f.end());
    entries[end[f[0]]++] = {f[1], f[2], i};
  }
  std::vector<std::uint32_t> duplicates;
  std::size_t begin = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); begin = end[v++]) {
    std::sort(entries.begin() + begin, entries.begin() + end[v]);
    for (std::size_t i = begin + 1; i < end[v]; ++i) {
      const Entry &a = entries[i - 1], &b = entries[i];
      if (a.middle == b.middle && a.high == b.high) duplicates.push_back(b.facet);
    }
  }
  std::sort(duplicates.begin(), duplicates.end());
  return duplicates;
}

bool has_area(const Mesh& mesh, const Facet& f) {
  const Vec3 ab = mesh.vertices[f[1]] - mesh.vertices[f[0]];
  const Vec3 bc = mesh.vertices[f[2]] - mesh.vertices[f[1]];
  const Vec3 ca = mesh.vertices[f[0]] - mesh.vertices[f[2]];
  const double longest = std::max({squared_length(ab), squared_length(bc), squared_length(ca)});
  // height = |ab x bc| / longest edge
  return squared_length(cross(ab, bc)) > kMinHeight * kMinHeight * longest;
}

std::vector<std::uint32_t> without_area(const Mesh& mesh) {
  return facets_where(mesh, [&mesh](const Facet& f) { return !has_area(mesh, f); });
}

void remove_facets(Mesh& mesh, const std::vector<std::uint32_t>& facets) {
  std::size_t kept = 0, next = 0;
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    if (next < facets.size() && facets[next] == i) {
      ++next;
      continue;
    }
    mesh.facets[kept] = mesh.facets[i];
    mesh.source[kept++] = mesh.source[i];
  }
  mesh.facets.resize(kept);
  mesh.source.resize(kept);

  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
  std::vector<Point<Part>> used;
  used.reserve(mesh.vertices.size());
  for (Facet& f : mesh.facets) {
    for (std::uint32_t& v : f) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(used.size());
        used.push_back(mesh.vertices[v]);
      }
      v = number[v];
    }
  }
  mesh.vertices = std::move(used);
}

}  // namespace tiltfeed::pathgen
