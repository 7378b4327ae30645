#pragma once
// A block with a straight valley, and axis fields over it.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed {
using namespace pathgen;

inline constexpr double kHalfLength = 15.0, kWallLength = 16.0;

/// A block with a valley of straight walls along y; `half`: half of the angle between them, rad.
inline CheckedMesh valley_block(double half) {
  const double x = kWallLength * std::sin(half), z = kWallLength * std::cos(half);
  const std::array<std::array<double, 2>, 5> outline{{{-x, -5}, {x, -5}, {x, z}, {0, 0}, {-x, z}}};
  Stl stl;
  const auto at = [&](std::size_t k, double y) {
    return Point<Part>{outline[k % 5][0], y, outline[k % 5][1]};
  };
  const double l = kHalfLength;
  for (std::size_t k = 0; k < 5; ++k) {
    stl.facets.push_back({at(k, -l), at(k + 1, -l), at(k + 1, l)});
    stl.facets.push_back({at(k, -l), at(k + 1, l), at(k, l)});
  }
  for (const auto& t : {std::array<std::size_t, 3>{0, 1, 3}, {1, 2, 3}, {0, 3, 4}}) {
    stl.facets.push_back({at(t[0], -l), at(t[2], -l), at(t[1], -l)});
    stl.facets.push_back({at(t[0], l), at(t[1], l), at(t[2], l)});
  }
  auto mesh = check_mesh(stl);
  EXPECT_TRUE(mesh) << mesh.error().message;
  return *mesh;
}

inline std::vector<AxisFrame> frames_over_a_valley() {
  AxisFrame fixed, line, point, circle;
  line.mode = AxisMode::kLine, line.origin = {0, 0, -60}, line.t = {0, 1, 0};
  point.mode = AxisMode::kPoint, point.origin = {0, 0, -80};
  circle.mode = AxisMode::kCircle, circle.origin = {0, 0, -130}, circle.circle_radius = 40.0;
  return {fixed, line, point, circle};
}

}  // namespace tiltfeed
