#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "kinematics/basics/units.h"
#include "pathgen/mesh/facet_winding.h"

namespace tiltfeed::pathgen {
namespace {

/// Solid angles and box comparisons that deciding what lies inside what may cost: about a second.
constexpr std::uint64_t kMaxWork = 40'000'000;
/// Fewer vertices of a shell than this are not trusted to tell that all of it lies inside another.
constexpr std::uint64_t kMinSamples = 32;

/// Facets that one task measures: some hundred microseconds of work.
constexpr std::size_t kBlockFacets = 16384;

struct Shell {
  double volume = 0.0;
  Box box;
};

double signed_volume(const Mesh& mesh, const Facet& f, Point<Part> origin) {
  const Vec3 a = mesh.vertices[f[0]] - origin, b = mesh.vertices[f[1]] - origin,
             c = mesh.vertices[f[2]] - origin;
  return dot(a, cross(b, c)) / 6.0;
}

/// A block's share of the shells that have facets in it, in the order of their first facet there.
struct Share {
  std::vector<std::pair<std::uint32_t, Shell>> shells;
  std::unordered_map<std::uint32_t, std::size_t> place;

  Shell& of(std::uint32_t shell, Point<Part> start) {
    if (!shells.empty() && shells[last_].first == shell) return shells[last_].second;
    const auto [at, added] = place.try_emplace(shell, shells.size());
    if (added) shells.push_back({shell, {0.0, {start, start}}});
    last_ = at->second;
    return shells[last_].second;
  }

 private:
  std::size_t last_ = 0;
};

/// Volumes and boxes of all shells: in blocks of facets, added up in their order, so that the sums are the
/// same for any number of threads.
std::vector<Shell> measure(const Mesh& mesh, const Shells& shells) {
  // Any origin will do for a closed shell; one of its own vertices keeps the digits.
  std::vector<Point<Part>> origin;
  for (std::size_t i = 0; i < mesh.facets.size() && origin.size() < shells.count; ++i)
    if (shells.of_facet[i] == origin.size()) origin.push_back(mesh.vertices[mesh.facets[i][0]]);
  std::vector<Share> shares((mesh.facets.size() + kBlockFacets - 1) / kBlockFacets);
  tbb::parallel_for(std::size_t{0}, shares.size(), [&](std::size_t b) {
    for (std::size_t i = b * kBlockFacets; i < std::min(mesh.facets.size(), (b + 1) * kBlockFacets); ++i) {
      const Facet& f = mesh.facets[i];
      const std::uint32_t number = shells.of_facet[i];
      Shell& shell = shares[b].of(number, mesh.vertices[f[0]]);
      shell.volume += signed_volume(mesh, f, origin[number]);
      for (std::uint32_t v : f) shell.box = grown(shell.box, mesh.vertices[v]);
    }
  });
  std::vector<Shell> out;
  for (const Point<Part>& p : origin) out.push_back({0.0, {p, p}});
  for (const Share& share : shares) {
    for (const auto& [number, part] : share.shells) {
      out[number].volume += part.volume;
      out[number].box = grown(grown(out[number].box, part.box.min), part.box.max);
    }
  }
  return out;
}

std::vector<std::vector<std::uint32_t>> facets_by_shell(const Shells& shells) {
  std::vector<std::vector<std::uint32_t>> facets(shells.count);
  for (std::uint32_t i = 0; i < shells.of_facet.size(); ++i) facets[shells.of_facet[i]].push_back(i);
  return facets;
}

bool strictly_inside(const Box& inner, const Box& outer) {
  return inner.min.x > outer.min.x && inner.min.y > outer.min.y && inner.min.z > outer.min.z &&
         inner.max.x < outer.max.x && inner.max.y < outer.max.y && inner.max.z < outer.max.z;
}

/// The winding number of a closed shell about p is its solid angle over 4 pi [van Oosterom 1983]: 0 outside,
/// +-1 inside.
bool contains(const Mesh& mesh, const std::vector<std::uint32_t>& shell, Point<Part> p) {
  double half_angle = 0.0;
  for (std::uint32_t i : shell) {
    const Facet& f = mesh.facets[i];
    const Vec3 a = mesh.vertices[f[0]] - p, b = mesh.vertices[f[1]] - p, c = mesh.vertices[f[2]] - p;
    const double la = length(a), lb = length(b), lc = length(c);
    half_angle +=
        std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return std::abs(half_angle) > kPi;  // half of the 2 pi of a point inside
}

/// Evenly spread vertices of `inner` all lie in `outer`; half of the work left may go into it.
/// Requires: work_left covers kMinSamples.
bool contains(const Mesh& mesh, const std::vector<std::uint32_t>& outer,
              const std::vector<std::uint32_t>& inner, std::uint64_t& work_left) {
  const std::uint64_t cost = outer.size();
  const std::uint64_t wanted = std::max(kMinSamples, work_left / 2 / cost);
  const std::uint64_t step = (inner.size() + wanted - 1) / wanted;
  for (std::uint64_t i = 0; i < inner.size(); i += step) {
    work_left -= cost;
    if (!contains(mesh, outer, mesh.vertices[mesh.facets[inner[i]][0]])) return false;
  }
  return true;
}

}  // namespace

InsideOut turn_outward(Mesh& mesh, const Shells& shells) {
  InsideOut result;
  const std::vector<Shell> all = measure(mesh, shells);
  if (std::none_of(all.begin(), all.end(), [](const Shell& s) { return s.volume < 0.0; })) return result;

  const std::vector<std::vector<std::uint32_t>> facets = facets_by_shell(shells);
  // Largest first: whatever contains a shell is decided before it.
  std::vector<std::uint32_t> order(all.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&all](std::uint32_t a, std::uint32_t b) {
    return std::abs(all[a].volume) > std::abs(all[b].volume);
  });
  std::vector<bool> turned(all.size(), false);
  std::uint64_t work_left = kMaxWork;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::uint32_t inner = order[k];
    bool turn = all[inner].volume < 0.0;
    for (std::size_t j = 0; j < k; ++j) {
      const Shell& outer = all[order[j]];
      if (work_left == 0) return {{}, false};
      --work_left;
      if (!strictly_inside(all[inner].box, outer.box)) continue;
      if (work_left < kMinSamples * facets[order[j]].size()) return {{}, false};
      if (!contains(mesh, facets[order[j]], facets[inner], work_left)) continue;
      turn = turned[order[j]];
      break;
    }
    turned[inner] = turn;
  }
  for (std::uint32_t s = 0; s < all.size(); ++s) {
    if (!turned[s]) continue;
    result.shells.push_back(s);
    for (std::uint32_t i : facets[s]) turn_over(mesh.facets[i]);
  }
  return result;
}

}  // namespace tiltfeed::pathgen
