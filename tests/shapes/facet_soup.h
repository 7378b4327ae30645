#pragma once
// Meshes of facets given by their corners, for the tests of distances; random ones among them.

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "sim/solid/distance.h"

namespace tiltfeed::sim {
using namespace pathgen;

using Corners = std::array<Point<Part>, 3>;

/// Corners at one place are one vertex.
inline Mesh mesh_of(const std::vector<Corners>& soup) {
  Mesh mesh;
  for (const Corners& t : soup) {
    std::array<std::uint32_t, 3> facet{};
    for (int k = 0; k < 3; ++k) {
      const auto found = std::find(mesh.vertices.begin(), mesh.vertices.end(), t[k]);
      facet[k] = static_cast<std::uint32_t>(found - mesh.vertices.begin());
      if (found == mesh.vertices.end()) mesh.vertices.push_back(t[k]);
    }
    mesh.facets.push_back(facet);
  }
  return mesh;
}

/// The first corners lie in a cube of half side `box`, the others up to `reach` from it along each axis.
inline std::vector<Corners> random_soup(std::mt19937_64& random, int count, double box, double reach) {
  std::uniform_real_distribution<double> place(-box, box), size(-reach, reach);
  std::vector<Corners> soup;
  for (int i = 0; i < count; ++i) {
    const Point<Part> a{place(random), place(random), place(random)};
    const auto near = [&] { return a + Vec3{size(random), size(random), size(random)}; };
    soup.push_back({a, near(), near()});
  }
  return soup;
}

}  // namespace tiltfeed::sim
