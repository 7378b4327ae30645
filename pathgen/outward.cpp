#include <algorithm>
#include <cmath>
#include <numeric>

#include "kinematics/units.h"
#include "pathgen/orient.h"

namespace tiltfeed {
namespace {

/// Solid angles and box comparisons that deciding what lies inside what may cost: about a second.
constexpr std::uint64_t kMaxWork = 40'000'000;
/// Fewer vertices of a shell than this are not trusted to tell that all of it lies inside another.
constexpr std::uint64_t kMinSamples = 32;

struct Shell {
  std::vector<std::uint32_t> facets;
  double volume = 0.0;
  Box box;
};

double signed_volume(const Mesh& mesh, const Facet& f, Point<Part> origin) {
  const Vec3 a = mesh.vertices[f[0]] - origin, b = mesh.vertices[f[1]] - origin,
             c = mesh.vertices[f[2]] - origin;
  return dot(a, cross(b, c)) / 6.0;
}

std::vector<Shell> measure(const Mesh& mesh, const Shells& shells) {
  std::vector<Shell> out(shells.count);
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    Shell& shell = out[shells.of_facet[i]];
    const Point<Part> start = mesh.vertices[mesh.facets[i][0]];
    if (shell.facets.empty()) shell.box = {start, start};
    shell.facets.push_back(i);
    // Any origin will do for a closed shell; one of its own vertices keeps the digits.
    const Point<Part> origin = mesh.vertices[mesh.facets[shell.facets[0]][0]];
    shell.volume += signed_volume(mesh, mesh.facets[i], origin);
    for (std::uint32_t v : mesh.facets[i]) {
      const Point<Part> p = mesh.vertices[v];
      shell.box.min = {std::min(shell.box.min.x, p.x), std::min(shell.box.min.y, p.y),
                       std::min(shell.box.min.z, p.z)};
      shell.box.max = {std::max(shell.box.max.x, p.x), std::max(shell.box.max.y, p.y),
                       std::max(shell.box.max.z, p.z)};
    }
  }
  return out;
}

bool strictly_inside(const Box& inner, const Box& outer) {
  return inner.min.x > outer.min.x && inner.min.y > outer.min.y && inner.min.z > outer.min.z &&
         inner.max.x < outer.max.x && inner.max.y < outer.max.y && inner.max.z < outer.max.z;
}

/// The winding number of a closed shell about p is its solid angle over 4 pi [van Oosterom 1983]: 0 outside,
/// +-1 inside.
bool contains(const Mesh& mesh, const Shell& shell, Point<Part> p) {
  double half_angle = 0.0;
  for (std::uint32_t i : shell.facets) {
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
bool contains(const Mesh& mesh, const Shell& outer, const Shell& inner, std::uint64_t& work_left) {
  const std::uint64_t cost = outer.facets.size();
  const std::uint64_t wanted = std::max(kMinSamples, work_left / 2 / cost);
  const std::uint64_t step = (inner.facets.size() + wanted - 1) / wanted;
  for (std::uint64_t i = 0; i < inner.facets.size(); i += step) {
    work_left -= cost;
    if (!contains(mesh, outer, mesh.vertices[mesh.facets[inner.facets[i]][0]])) return false;
  }
  return true;
}

}  // namespace

InsideOut turn_outward(Mesh& mesh, const Shells& shells) {
  InsideOut result;
  const std::vector<Shell> all = measure(mesh, shells);
  if (std::none_of(all.begin(), all.end(), [](const Shell& s) { return s.volume < 0.0; })) return result;

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
      if (work_left < kMinSamples * outer.facets.size()) return {{}, false};
      if (!contains(mesh, outer, all[inner], work_left)) continue;
      turn = turned[order[j]];
      break;
    }
    turned[inner] = turn;
  }
  for (std::uint32_t s = 0; s < all.size(); ++s) {
    if (!turned[s]) continue;
    result.shells.push_back(s);
    for (std::uint32_t i : all[s].facets) turn_over(mesh.facets[i]);
  }
  return result;
}

}  // namespace tiltfeed
