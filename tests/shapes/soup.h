#pragma once
// Triangle soups made by the tests, and what brute force over their coordinates says of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed::soup {
using namespace pathgen;

using Corners = std::array<Point<Part>, 3>;
using Soup = std::vector<Corners>;
using Triple = std::array<double, 3>;
using Triangle = std::array<Triple, 3>;

inline Triple triple(Point<Part> p) { return {p.x + 0.0, p.y + 0.0, p.z + 0.0}; }

/// The corners with the lowest first and the sense kept: equal for equal oriented facets.
inline Triangle canonical(const Corners& f) {
  Triangle t{triple(f[0]), triple(f[1]), triple(f[2])};
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

inline Corners reversed(const Corners& f) { return {f[0], f[2], f[1]}; }
inline Soup reversed(Soup soup) {
  for (Corners& f : soup) f = reversed(f);
  return soup;
}
inline Soup operator+(Soup a, const Soup& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline void add_quad(Soup& soup, Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
  soup.push_back({a, b, c});
  soup.push_back({a, c, d});
}

/// Facets 0, 1 are the bottom; all normals point out.
inline Soup box(Point<Part> lo, Point<Part> hi) {
  const auto at = [&](int x, int y, int z) {
    return Point<Part>{x ? hi.x : lo.x, y ? hi.y : lo.y, z ? hi.z : lo.z};
  };
  Soup s;
  add_quad(s, at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
  add_quad(s, at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1));
  add_quad(s, at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
  add_quad(s, at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1));
  add_quad(s, at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
  add_quad(s, at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1));
  return s;
}
inline Soup cube(double lo, double hi) { return box({lo, lo, lo}, {hi, hi, hi}); }

/// An L of 6 x 6 x 6 with arms 2 wide: volume 120; the notch is x, y > 2.
inline Soup ell() {
  const double outline[6][2] = {{0, 0}, {6, 0}, {6, 2}, {2, 2}, {2, 6}, {0, 6}};
  const auto at = [&](int i, double z) { return Point<Part>{outline[i % 6][0], outline[i % 6][1], z}; };
  Soup s;
  for (int i = 0; i < 6; ++i) add_quad(s, at(i, 0), at(i + 1, 0), at(i + 1, 6), at(i, 6));
  for (int i = 1; i < 5; ++i) {
    s.push_back({at(0, 6), at(i, 6), at(i + 1, 6)});
    s.push_back({at(0, 0), at(i + 1, 0), at(i, 0)});
  }
  return s;
}

/// A torus of 2 * 12 * 8 facets, corners shared exactly.
inline Soup torus() {
  const auto at = [](int i, int j) {
    const double u = 2 * M_PI * (i % 12) / 12, v = 2 * M_PI * (j % 8) / 8;
    return Point<Part>{(5 + 2 * std::cos(v)) * std::cos(u), (5 + 2 * std::cos(v)) * std::sin(u),
                       2 * std::sin(v)};
  };
  Soup s;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 8; ++j) add_quad(s, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  return s;
}

/// A strip of 2 n facets with half a turn.
inline Soup moebius(int n) {
  const auto at = [n](int i, bool upper) {
    const bool wrapped = i == n;
    const double u = wrapped ? 0.0 : 2 * M_PI * i / n;
    const double w = (upper != wrapped) ? 1.0 : -1.0;
    const double r = 5 + w * std::cos(u / 2);
    return Point<Part>{r * std::cos(u), r * std::sin(u), w * std::sin(u / 2)};
  };
  Soup s;
  for (int i = 0; i < n; ++i) add_quad(s, at(i, false), at(i + 1, false), at(i + 1, true), at(i, true));
  return s;
}

inline Stl stl_of(Soup soup) {
  Stl stl;
  stl.facets = std::move(soup);
  return stl;
}

inline CheckedMesh check(const Soup& soup) {
  Result<CheckedMesh> mesh = check_mesh(stl_of(soup));
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().message);
  return mesh ? *mesh : CheckedMesh{};
}

inline std::map<DefectKind, std::uint64_t> counts(const CheckedMesh& mesh) {
  std::map<DefectKind, std::uint64_t> out;
  for (const Defect& d : mesh.defects) out[d.kind] = d.count;
  return out;
}
using Counts = std::map<DefectKind, std::uint64_t>;

inline Soup corners_of(const Mesh& mesh) {
  Soup soup;
  for (const auto& f : mesh.facets)
    soup.push_back({mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]});
  return soup;
}

/// By brute force over coordinates: the facets on each edge, +1 or -1 for its sense.
inline std::map<std::pair<Triple, Triple>, std::vector<int>> edges_of(const Soup& soup) {
  std::map<std::pair<Triple, Triple>, std::vector<int>> edges;
  for (const Corners& f : soup) {
    for (int k = 0; k < 3; ++k) {
      const Triple a = triple(f[k]), b = triple(f[(k + 1) % 3]);
      edges[{std::min(a, b), std::max(a, b)}].push_back(a < b ? 1 : -1);
    }
  }
  return edges;
}

inline bool is_closed(const Soup& soup) {
  const auto edges = edges_of(soup);
  return std::all_of(edges.begin(), edges.end(), [](const auto& edge) {
    return edge.second.size() == 2 && edge.second[0] + edge.second[1] == 0;
  });
}

inline Counts edge_defects(const Soup& soup) {
  Counts out;
  for (const auto& [ends, senses] : edges_of(soup)) {
    if (senses.size() == 1) ++out[DefectKind::kOpenEdge];
    if (senses.size() > 2) ++out[DefectKind::kNonManifold];
    if (senses.size() == 2 && senses[0] == senses[1]) ++out[DefectKind::kMisoriented];
  }
  return out;
}

inline std::set<Triangle> canonical(const Soup& soup) {
  std::set<Triangle> out;
  for (const Corners& f : soup) out.insert(canonical(f));
  return out;
}

}  // namespace tiltfeed::soup
