#include "pathgen/mesh/pinches.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {
namespace {

/// Facets closer than this round their edge lie on each other: which is first cannot be told, rad.
constexpr double kSameAngle = 1e-9;

/// Two facets that enclose material at an edge.
struct Hinge {
  std::uint32_t low, high;  ///< the edge
  std::uint32_t first, second;
};

double signed_volume(const Mesh& mesh) {
  const Point<Part> origin = mesh.vertices[mesh.facets[0][0]];
  double six = 0.0;
  for (const Facet& f : mesh.facets)
    six +=
        dot(mesh.vertices[f[0]] - origin, cross(mesh.vertices[f[1]] - origin, mesh.vertices[f[2]] - origin));
  return six / 6.0;
}

/// Seen along the edge from low to high, a facet that runs forward has its material at smaller angles, one
/// that runs back at larger ones: each backward facet encloses material with the forward one after it.
/// `inside_out`: the other way round.
std::vector<Hinge> hinges_of(const Mesh& mesh, std::span<const HalfEdge> edge, bool inside_out) {
  const Point<Part> a = mesh.vertices[edge[0].low];
  const Vec3 axis = normalized(mesh.vertices[edge[0].high] - a);
  struct Leaf {
    double angle;
    bool forward;
    std::uint32_t facet;
  };
  std::vector<Leaf> leaves;
  Vec3 u, v;
  for (const HalfEdge& half : edge) {
    const Facet& f = mesh.facets[half.facet];
    const std::uint32_t apex = f[0] ^ f[1] ^ f[2] ^ half.low ^ half.high;
    const Vec3 to_apex = mesh.vertices[apex] - a;
    const Vec3 out = to_apex - axis * dot(to_apex, axis);
    if (leaves.empty()) u = normalized(out), v = cross(axis, u);
    leaves.push_back({std::atan2(dot(out, v), dot(out, u)), half.forward != inside_out, half.facet});
  }
  std::sort(leaves.begin(), leaves.end(), [](const Leaf& x, const Leaf& y) { return x.angle < y.angle; });
  std::vector<Hinge> hinges;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Leaf &here = leaves[i], &next = leaves[(i + 1) % leaves.size()];
    const double wedge = next.angle - here.angle + (i + 1 == leaves.size() ? 2 * kPi : 0.0);
    if (here.forward == next.forward || wedge < kSameAngle) return {};
    if (!here.forward) hinges.push_back({edge[0].low, edge[0].high, here.facet, next.facet});
  }
  return hinges;
}

/// Facets round one vertex, grouped by the edges there that join them.
class Umbrellas {
 public:
  explicit Umbrellas(std::vector<std::uint32_t> facets)
      : facets_(std::move(facets)), parent_(facets_.size()) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  void join(std::uint32_t a, std::uint32_t b) {
    const std::size_t i = root(index(a)), j = root(index(b));
    parent_[std::max(i, j)] = std::min(i, j);
  }
  /// The facets of each group but the first.
  std::vector<std::vector<std::uint32_t>> others() {
    std::map<std::size_t, std::vector<std::uint32_t>> groups;
    for (std::size_t i = 0; i < facets_.size(); ++i) groups[root(i)].push_back(facets_[i]);
    groups.erase(groups.begin());
    std::vector<std::vector<std::uint32_t>> out;
    for (auto& [first, group] : groups) out.push_back(std::move(group));
    return out;
  }

 private:
  std::size_t index(std::uint32_t facet) const {
    return static_cast<std::size_t>(std::lower_bound(facets_.begin(), facets_.end(), facet) -
                                    facets_.begin());
  }
  std::size_t root(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  std::vector<std::uint32_t> facets_;  ///< ascending
  std::vector<std::size_t> parent_;
};

}  // namespace

Found separate_pinches(Mesh& mesh) {
  Found found;
  const VertexFans fans(mesh.facets, mesh.vertices.size());
  const bool inside_out = signed_volume(mesh) < 0.0;
  std::vector<Hinge> hinges;
  std::map<std::uint32_t, std::vector<std::uint32_t>> round;  // facets round the ends of pinched edges
  fans.each_edge([&](std::span<const HalfEdge> edge) {
    if (edge.size() < 3) return;
    const std::vector<Hinge> here = hinges_of(mesh, edge, inside_out);
    if (here.empty()) return;
    hinges.insert(hinges.end(), here.begin(), here.end());
    round[edge[0].low], round[edge[0].high];
    const std::uint32_t source = mesh.source[edge[0].facet];
    found.first = found.count == 0 ? source : std::min(found.first, source);
    ++found.count;
  });
  if (hinges.empty()) return found;
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i)
    for (std::uint32_t v : mesh.facets[i])
      if (const auto at = round.find(v); at != round.end()) at->second.push_back(i);
  std::map<std::uint32_t, Umbrellas> umbrellas;
  for (auto& [v, facets] : round) umbrellas.emplace(v, std::move(facets));
  const auto join = [&](std::uint32_t v, std::uint32_t a, std::uint32_t b) {
    if (const auto at = umbrellas.find(v); at != umbrellas.end()) at->second.join(a, b);
  };
  fans.each_edge([&](std::span<const HalfEdge> edge) {
    if (edge.size() != 2) return;
    for (std::uint32_t v : {edge[0].low, edge[0].high}) join(v, edge[0].facet, edge[1].facet);
  });
  for (const Hinge& h : hinges)
    for (std::uint32_t v : {h.low, h.high}) join(v, h.first, h.second);
  for (auto& [v, all] : umbrellas) {
    for (const std::vector<std::uint32_t>& group : all.others()) {
      const auto copy = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(Point<Part>{mesh.vertices[v]});
      for (std::uint32_t i : group) std::replace(mesh.facets[i].begin(), mesh.facets[i].end(), v, copy);
    }
  }
  return found;
}

}  // namespace tiltfeed::pathgen
