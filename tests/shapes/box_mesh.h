#pragma once
// A part of boxes, for tests.

#include <array>
#include <cstdint>
#include <vector>

#include "pathgen/mesh/mesh.h"

namespace tiltfeed {
using namespace pathgen;

/// Boxes from low to high corner, twelve facets each, numbered from 1000 on in the STL file.
inline Mesh box_mesh(const std::vector<std::array<Vec3, 2>>& boxes) {
  Mesh mesh;
  for (const auto& [low, high] : boxes) {
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int i = 0; i < 8; ++i)
      mesh.vertices.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    const std::uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& q : quads) {
      mesh.facets.push_back({base + q[0], base + q[1], base + q[2]});
      mesh.facets.push_back({base + q[0], base + q[2], base + q[3]});
    }
  }
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) mesh.source.push_back(i + 1000);
  return mesh;
}

}  // namespace tiltfeed
