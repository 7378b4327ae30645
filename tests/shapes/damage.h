#pragma once
// Sound soups damaged on purpose, from a seed, and measures of what a repair made of them.

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "sim/solid/distance.h"
#include "tests/shapes/soup.h"

namespace tiltfeed::damage {
using namespace pathgen;

using namespace soup;
using Random = std::mt19937;

/// Of the default options of a repair, mm.
inline constexpr double kDistance = 0.0025;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline std::size_t below(Random& random, std::size_t n) {
  return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
}

inline double volume_of(const Soup& s) {
  double six = 0.0;
  for (const Corners& f : s) six += dot(f[0] - s[0][0], cross(f[1] - s[0][0], f[2] - s[0][0]));
  return six / 6.0;
}
inline double area_of(const Soup& s) {
  double twice = 0.0;
  for (const Corners& f : s) twice += length(cross(f[1] - f[0], f[2] - f[0]));
  return twice / 2.0;
}

/// The largest distance of corners, middles of edges and centres of `from` to the facets of `to`.
inline double one_sided(const Soup& from, const Soup& to) {
  Mesh mesh;
  for (const Corners& f : to) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), f.begin(), f.end());
    mesh.facets.push_back({first, first + 1, first + 2});
  }
  const sim::PartDistance distance(mesh);
  double worst = 0.0;
  for (const Corners& f : from) {
    const Point<Part> centre = lerp(lerp(f[0], f[1], 0.5), f[2], 1.0 / 3);
    for (const Point<Part>& p :
         {f[0], f[1], f[2], lerp(f[0], f[1], 0.5), lerp(f[1], f[2], 0.5), lerp(f[2], f[0], 0.5), centre})
      worst = std::max(worst, distance.nearest(p).value);
  }
  return worst;
}
inline double hausdorff(const Soup& a, const Soup& b) { return std::max(one_sided(a, b), one_sided(b, a)); }

/// Every corner of every facet moved on its own, by up to `size` each way.
inline void crack(Soup& soup, double size, Random& random) {
  for (Corners& f : soup)
    for (Point<Part>& p : f)
      p = p + Vec3{uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}
inline void turn_some(Soup& soup, int percent, Random& random) {
  for (Corners& f : soup)
    if (below(random, 100) < static_cast<std::size_t>(percent)) f = reversed(f);
}
inline void repeat_some(Soup& soup, int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    const Corners f = soup[below(random, soup.size())];
    soup.push_back(i % 2 ? reversed(f) : Corners{f[1], f[2], f[0]});
  }
}
/// Takes out facets no two of which share a corner.
inline std::size_t remove_some(Soup& soup, std::size_t count, Random& random) {
  std::set<Triple> used;
  std::size_t removed = 0;
  while (removed < count) {
    const std::size_t at = below(random, soup.size());
    const Corners f = soup[at];
    if (used.contains(triple(f[0])) || used.contains(triple(f[1])) || used.contains(triple(f[2]))) continue;
    for (const Point<Part>& p : f) used.insert(triple(p));
    soup.erase(soup.begin() + static_cast<std::ptrdiff_t>(at));
    ++removed;
  }
  return removed;
}
/// Halves facets along their first edge and moves the new corner by up to `size`; their neighbours know
/// nothing of it.
inline void cut_some(Soup& soup, std::size_t count, double size, Random& random) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = below(random, soup.size());
    const auto [a, b, c] = soup[at];
    const Vec3 off = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 0.1, 1)});
    const Point<Part> m = lerp(a, b, uniform(random, 0.3, 0.7)) + off * uniform(random, 0, size);
    soup[at] = {a, m, c};
    soup.push_back({m, b, c});
  }
}

}  // namespace tiltfeed::damage
