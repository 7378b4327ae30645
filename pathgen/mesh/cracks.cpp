#include "pathgen/mesh/cracks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "kinematics/basics/tool_path.h"

namespace tiltfeed::pathgen {
namespace {

/// A cut facet's pieces may need a cut of their own along another edge; a mesh that goes on for longer than
/// this is no mesh with cracks.
constexpr int kMaxRounds = 16;

/// Points halved again and again in x, y and z (a k-d tree; the middle point stands between the halves): who
/// is near a segment.
class Nearby {
 public:
  Nearby(std::vector<std::uint32_t> ids, const std::vector<Point<Part>>& points)
      : ids_(std::move(ids)), points_(points) {
    arrange(0, ids_.size(), 0);
  }

  /// Calls visit(id) for the points within `reach` of the segment from a to b, in no order to rely on.
  template <class Visit>
  void each_near(Point<Part> a, Point<Part> b, double reach, const Visit& visit) const {
    search({a, b, reach}, 0.0, 1.0, 0, ids_.size(), 0, visit);
  }

 private:
  static constexpr std::size_t kLeaf = 8;
  struct Query {
    Point<Part> a, b;
    double reach;
  };
  static double coordinate(Point<Part> p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

  void arrange(std::size_t begin, std::size_t end, int axis) {
    if (end - begin <= kLeaf) return;
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(ids_.begin() + begin, ids_.begin() + middle, ids_.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) {
                       return coordinate(points_[i], axis) < coordinate(points_[j], axis);
                     });
    arrange(begin, middle, (axis + 1) % 3);
    arrange(middle + 1, end, (axis + 1) % 3);
  }

  template <class Visit>
  void test(const Query& q, std::uint32_t id, const Visit& visit) const {
    if (distance_to_segment(points_[id], q.a, q.b) <= q.reach) visit(id);
  }

  /// Only the part from `from` to `to` (fractions) of the segment can be near the points left.
  template <class Visit>
  void search(const Query& q, double from, double to, std::size_t begin, std::size_t end, int axis,
              const Visit& visit) const {
    if (end - begin <= kLeaf) {
      for (std::size_t i = begin; i < end; ++i) test(q, ids_[i], visit);
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    test(q, ids_[middle], visit);
    const double plane = coordinate(points_[ids_[middle]], axis);
    const double start = coordinate(q.a, axis), run = coordinate(q.b, axis) - start;
    // Points of the lower half can be near where start + f run <= plane + reach; the upper half, >= plane -
    // reach.
    double low_from = from, low_to = to, high_from = from, high_to = to;
    const double low = plane + q.reach - start, high = plane - q.reach - start;
    if (run > 0.0) low_to = std::min(to, low / run), high_from = std::max(from, high / run);
    if (run < 0.0) low_from = std::max(from, low / run), high_to = std::min(to, high / run);
    if (low_from <= low_to && (run != 0.0 || low >= 0.0))
      search(q, low_from, low_to, begin, middle, (axis + 1) % 3, visit);
    if (high_from <= high_to && (run != 0.0 || high <= 0.0))
      search(q, high_from, high_to, middle + 1, end, (axis + 1) % 3, visit);
  }

  std::vector<std::uint32_t> ids_;
  const std::vector<Point<Part>>& points_;
};

/// The ends of open edges, ascending.
std::vector<std::uint32_t> rim_corners(const VertexFans& fans) {
  std::vector<std::uint32_t> corners;
  fans.each_edge([&](std::span<const HalfEdge> edge) {
    if (edge.size() == 1) corners.insert(corners.end(), {edge[0].low, edge[0].high});
  });
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

void note(Found& found, const Mesh& mesh, std::uint32_t facet) {
  const std::uint32_t source = mesh.source[facet];
  if (found.count == 0 || source < found.first) found.first = source;
  ++found.count;
}

/// The corners that cut the edge of a facet, in their order along it.
struct Cut {
  std::uint32_t facet = kNoFacet;
  std::vector<std::uint32_t> corners;
};

Cut cut_of(const Mesh& mesh, const HalfEdge& edge, const Nearby& near, double distance) {
  Cut cut{edge.facet, {}};
  const Facet& f = mesh.facets[edge.facet];
  const std::uint32_t from = edge.forward ? edge.low : edge.high, to = edge.forward ? edge.high : edge.low;
  const Point<Part> a = mesh.vertices[from], b = mesh.vertices[to];
  std::vector<std::pair<double, std::uint32_t>> along;
  near.each_near(a, b, distance, [&](std::uint32_t v) {
    const double at = dot(mesh.vertices[v] - a, b - a);
    const bool inside = at > 0.0 && at < squared_length(b - a);
    if (inside && v != f[0] && v != f[1] && v != f[2]) along.push_back({at, v});
  });
  std::sort(along.begin(), along.end());
  for (const auto& [at, v] : along) cut.corners.push_back(v);
  return cut;
}

/// The facets on either side of the cut corners, `from` being the first corner of the edge they are on.
void cut_up(const Facet& facet, std::uint32_t from, const std::vector<std::uint32_t>& corners,
            std::vector<Facet>& pieces) {
  const auto at = static_cast<std::size_t>(std::find(facet.begin(), facet.end(), from) - facet.begin());
  const std::uint32_t to = facet[(at + 1) % 3], apex = facet[(at + 2) % 3];
  std::uint32_t last = from;
  for (std::uint32_t v : corners) {
    pieces.push_back({last, v, apex});
    last = v;
  }
  pieces.push_back({last, to, apex});
}

}  // namespace

Found weld_corners(Mesh& mesh, const VertexFans& fans, double distance) {
  Found found;
  const std::vector<std::uint32_t> rim = rim_corners(fans);
  const Nearby near(rim, mesh.vertices);
  std::vector<std::uint32_t> onto(mesh.vertices.size());
  std::iota(onto.begin(), onto.end(), 0U);
  std::vector<bool> settled(mesh.vertices.size(), false);
  std::uint64_t moved = 0;
  for (std::uint32_t v : rim) {
    if (settled[v]) continue;
    settled[v] = true;
    near.each_near(mesh.vertices[v], mesh.vertices[v], distance, [&](std::uint32_t u) {
      if (settled[u]) return;
      settled[u] = true;
      onto[u] = v;
      ++moved;
    });
  }
  if (moved == 0) return found;
  std::vector<std::uint32_t> collapsed;
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    Facet& f = mesh.facets[i];
    const Facet before = f;
    for (std::uint32_t& v : f) v = onto[v];
    if (f != before) note(found, mesh, i);
    if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) collapsed.push_back(i);
  }
  found.count = moved;
  remove_facets(mesh, collapsed);
  remove_facets(mesh, find_duplicates(mesh));
  return found;
}

Found split_at_corners(Mesh& mesh, double distance) {
  Found found;
  for (int round = 0; round < kMaxRounds; ++round) {
    const VertexFans fans(mesh.facets, mesh.vertices.size());
    const Nearby near(rim_corners(fans), mesh.vertices);
    std::map<std::uint32_t, std::pair<std::uint32_t, Cut>>
        cuts;  // by facet, with the first corner of the edge
    fans.each_edge([&](std::span<const HalfEdge> edge) {
      if (edge.size() != 1 || cuts.contains(edge[0].facet)) return;
      Cut cut = cut_of(mesh, edge[0], near, distance);
      const std::uint32_t from = edge[0].forward ? edge[0].low : edge[0].high;
      if (!cut.corners.empty()) cuts[cut.facet] = {from, std::move(cut)};
    });
    if (cuts.empty()) break;
    std::vector<Facet> facets;
    std::vector<std::uint32_t> source;
    for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
      const auto at = cuts.find(i);
      if (at == cuts.end()) {
        facets.push_back(mesh.facets[i]);
      } else {
        note(found, mesh, i);
        cut_up(mesh.facets[i], at->second.first, at->second.second.corners, facets);
      }
      source.resize(facets.size(), mesh.source[i]);
    }
    mesh.facets = std::move(facets);
    mesh.source = std::move(source);
  }
  return found;
}

Found drop_flaps(Mesh& mesh, double distance) {
  Found found;
  for (int round = 0; round < kMaxRounds; ++round) {
    const VertexFans fans(mesh.facets, mesh.vertices.size());
    std::vector<std::uint32_t> rim, flaps;
    fans.each_edge([&](std::span<const HalfEdge> edge) {
      if (edge.size() == 1) rim.push_back(edge[0].facet);
    });
    std::sort(rim.begin(), rim.end());
    fans.each_edge([&](std::span<const HalfEdge> edge) {
      if (edge.size() < 3) return;
      const Point<Part> a = mesh.vertices[edge[0].low], b = mesh.vertices[edge[0].high];
      for (const HalfEdge& half : edge) {
        if (!std::binary_search(rim.begin(), rim.end(), half.facet)) continue;
        double height = 0.0;
        for (std::uint32_t v : mesh.facets[half.facet])
          height = std::max(height, distance_to_segment(mesh.vertices[v], a, b));
        if (height <= distance) flaps.push_back(half.facet);
      }
    });
    if (flaps.empty()) break;
    std::sort(flaps.begin(), flaps.end());
    flaps.erase(std::unique(flaps.begin(), flaps.end()), flaps.end());
    for (std::uint32_t i : flaps) note(found, mesh, i);
    remove_facets(mesh, flaps);
  }
  return found;
}

}  // namespace tiltfeed::pathgen
