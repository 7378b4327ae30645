#include "pathgen/weld.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "pathgen/topology.h"

namespace tiltfeed {
namespace {

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

/// Numbers points by first occurrence: open addressing, at most half full.
class PointIndex {
 public:
  explicit PointIndex(std::size_t expected) : slots_(std::bit_ceil(expected * 2 + 16), kNone) {}

  std::uint32_t index(Point<Part> p) {
    p = {p.x + 0.0, p.y + 0.0, p.z + 0.0};  // -0 becomes 0
    std::uint32_t& slot = find(p);
    if (slot != kNone) return slot;
    const auto added = static_cast<std::uint32_t>(points.size());
    slot = added;
    points.push_back(p);
    if (points.size() * 2 > slots_.size()) grow();
    return added;
  }

  std::vector<Point<Part>> points;

 private:
  std::uint32_t& find(Point<Part> p) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = hash(p) & mask;
    while (slots_[at] != kNone && points[slots_[at]] != p) at = (at + 1) & mask;
    return slots_[at];
  }
  void grow() {
    slots_.assign(slots_.size() * 2, kNone);
    for (std::uint32_t i = 0; i < points.size(); ++i) find(points[i]) = i;
  }

  std::vector<std::uint32_t> slots_;
};

void note(Found& found, std::uint32_t stl_facet) {
  if (found.count == 0 || stl_facet < found.first) found.first = stl_facet;
  ++found.count;
}

/// Facets on the same three vertices as an earlier one, ascending.
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

/// Of the facets without area (ascending), those that seam: facets that hang together, all of whose edges
/// have two facets.
std::vector<std::uint32_t> find_seams(const Mesh& mesh, const std::vector<std::uint32_t>& thin) {
  if (thin.empty()) return {};
  std::vector<bool> is_thin(mesh.facets.size(), false);
  for (std::uint32_t i : thin) is_thin[i] = true;
  const EdgeTable edges(mesh.facets, mesh.vertices.size());

  // Groups of thin facets that share an edge, whatever else is on it; the root is the lowest facet.
  std::vector<std::uint32_t> parent(mesh.facets.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<bool> seams(mesh.facets.size(), true);  // of a root: its group still may seam
  std::vector<std::uint32_t> torn;                    // facets on an edge that has not two facets
  edges.each_edge([&](std::span<const HalfEdge> edge) {
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

}  // namespace

Welded weld(const Stl& stl) {
  Welded out;
  PointIndex index(stl.facets.size());  // a closed mesh has half as many vertices as facets
  out.mesh.facets.reserve(stl.facets.size());
  out.mesh.source.reserve(stl.facets.size());
  for (std::uint32_t i = 0; i < stl.facets.size(); ++i) {
    const auto& corners = stl.facets[i];
    const Facet f{index.index(corners[0]), index.index(corners[1]), index.index(corners[2])};
    if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) {
      note(out.degenerate, i);
      continue;
    }
    out.mesh.facets.push_back(f);
    out.mesh.source.push_back(i);
  }
  out.mesh.vertices = std::move(index.points);

  const std::vector<std::uint32_t> duplicates = find_duplicates(out.mesh);
  for (std::uint32_t i : duplicates) note(out.duplicate, out.mesh.source[i]);
  remove_facets(out.mesh, duplicates);

  std::vector<std::uint32_t> thin;
  for (std::uint32_t i = 0; i < out.mesh.facets.size(); ++i)
    if (!has_area(out.mesh, out.mesh.facets[i])) thin.push_back(i);
  for (std::uint32_t i : thin) note(out.degenerate, out.mesh.source[i]);
  const std::vector<std::uint32_t> seams = find_seams(out.mesh, thin);
  std::vector<std::uint32_t> dropped;
  std::set_difference(thin.begin(), thin.end(), seams.begin(), seams.end(), std::back_inserter(dropped));
  for (std::uint32_t i : seams) {
    const auto before = std::lower_bound(dropped.begin(), dropped.end(), i) - dropped.begin();
    out.seams.push_back(i - static_cast<std::uint32_t>(before));
  }
  remove_facets(out.mesh, dropped);
  return out;
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

}  // namespace tiltfeed
