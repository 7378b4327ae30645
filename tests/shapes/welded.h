#pragma once
// A built part as a reader of its STL would see it, and a search for facets that cross.

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "sim/parts/parts.h"

namespace tiltfeed::sim {

/// A part welded by exact equality, as a reader of its STL would.
struct Welded {
  std::vector<Point<Part>> vertices;
  std::vector<std::array<int, 3>> facets;
  std::set<std::pair<int, int>> edges;  ///< directed
  bool edge_twice = false;
};

inline Welded weld(const Triangles& triangles) {
  Welded mesh;
  std::map<std::array<double, 3>, int> known;
  for (const auto& triangle : triangles) {
    std::array<int, 3> facet{};
    for (int i = 0; i < 3; ++i) {
      const Point<Part> p = triangle[i];
      const auto [at, is_new] = known.try_emplace({p.x, p.y, p.z}, static_cast<int>(known.size()));
      if (is_new) mesh.vertices.push_back(p);
      facet[i] = at->second;
    }
    mesh.facets.push_back(facet);
    for (int i = 0; i < 3; ++i) mesh.edge_twice |= !mesh.edges.insert({facet[i], facet[(i + 1) % 3]}).second;
  }
  return mesh;
}

inline double six_volumes(Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
  return dot(b - a, cross(c - a, d - a));
}

/// The open segment a-b passes through the inside of the triangle, clear of its plane and edges.
inline bool pierces(Point<Part> a, Point<Part> b, const std::array<Point<Part>, 3>& t) {
  constexpr double kTouch =
      1e-6;  // mm^3; float32 rounding of a 400 mm coordinate over 2 mm facets is 1e-4 mm
  const double side_a = six_volumes(t[0], t[1], t[2], a), side_b = six_volumes(t[0], t[1], t[2], b);
  if (!(std::min(side_a, side_b) < -kTouch && std::max(side_a, side_b) > kTouch)) return false;
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 3; ++i) {
    const double turn = six_volumes(a, b, t[i], t[(i + 1) % 3]);
    low = std::min(low, turn);
    high = std::max(high, turn);
  }
  return low > kTouch || high < -kTouch;
}

/// Edges that pierce facets which do not share a corner with them: 0 for a solid.
inline int count_crossings(const Triangles& triangles, double cell) {
  const Welded mesh = weld(triangles);
  const auto key = [&](double x) { return static_cast<int>(std::floor(x / cell)); };
  std::map<std::array<int, 3>, std::vector<int>> grid;
  const auto for_cells = [&](std::initializer_list<Point<Part>> points, const auto& visit) {
    const auto [x0, x1] =
        std::minmax_element(points.begin(), points.end(), [](auto a, auto b) { return a.x < b.x; });
    const auto [y0, y1] =
        std::minmax_element(points.begin(), points.end(), [](auto a, auto b) { return a.y < b.y; });
    const auto [z0, z1] =
        std::minmax_element(points.begin(), points.end(), [](auto a, auto b) { return a.z < b.z; });
    for (int x = key(x0->x); x <= key(x1->x); ++x)
      for (int y = key(y0->y); y <= key(y1->y); ++y)
        for (int z = key(z0->z); z <= key(z1->z); ++z) visit(std::array{x, y, z});
  };
  for (int f = 0; f < static_cast<int>(triangles.size()); ++f)
    for_cells({triangles[f][0], triangles[f][1], triangles[f][2]}, [&](auto at) { grid[at].push_back(f); });
  int crossings = 0;
  for (const std::pair<int, int>& edge : mesh.edges) {
    const int from = edge.first, to = edge.second;
    if (from > to) continue;
    const Point<Part> a = mesh.vertices[from], b = mesh.vertices[to];
    for_cells({a, b}, [&](auto at) {
      const auto facets = grid.find(at);
      if (facets == grid.end()) return;
      for (const int f : facets->second) {
        const auto& corners = mesh.facets[f];
        const bool touches =
            std::any_of(corners.begin(), corners.end(), [&](int v) { return v == from || v == to; });
        crossings += !touches && pierces(a, b, triangles[f]);
      }
    });
  }
  return crossings;
}

}  // namespace tiltfeed::sim
