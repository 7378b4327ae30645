#pragma once
// Closed parts whose reach is known in closed form: bodies of revolution, and a bar with a slot.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed {
using namespace pathgen;

/// (r, z) from the axis round the material and back to the axis, the material on the left.
using Outline = std::vector<std::array<double, 2>>;

inline CheckedMesh checked(const Stl& stl) {
  auto mesh = check_mesh(stl);
  EXPECT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->sides, Sides::kOutward);
  return *mesh;
}

/// About z, in `segments` flat strips whose edges lie on the round surface.
inline void revolve(const Outline& outline, int segments, Stl& stl) {
  const auto at = [&](std::size_t i, int k) {
    const double turn = 2.0 * kPi * (k % segments) / segments, r = outline[i][0];
    return r == 0.0 ? Point<Part>{0, 0, outline[i][1]}
                    : Point<Part>{r * std::cos(turn), r * std::sin(turn), outline[i][1]};
  };
  for (std::size_t i = 0; i + 1 < outline.size(); ++i)
    for (int k = 0; k < segments; ++k) {
      const Point<Part> a = at(i, k), b = at(i, k + 1), c = at(i + 1, k + 1), d = at(i + 1, k);
      if (!(a == b)) stl.facets.push_back({a, b, c});
      if (!(c == d)) stl.facets.push_back({a, c, d});
    }
}

/// From polar angle `from` to `to` (rad, from +z) on a circle about the origin.
inline void arc(Outline& outline, double radius, double from, double to, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const double polar = from + (to - from) * i / steps;
    const bool on_axis = std::abs(std::sin(polar)) < 1e-12;
    outline.push_back({on_axis ? 0.0 : radius * std::sin(polar), radius * std::cos(polar)});
  }
}

inline CheckedMesh solid_ball(double radius, int steps) {
  Outline outline;
  arc(outline, radius, kPi, 0.0, steps);
  Stl stl;
  revolve(outline, 2 * steps, stl);
  return checked(stl);
}

/// A shell with a round hole of radius `hole` about +z (0: none, closed).
inline CheckedMesh hollow_ball(double inner, double outer, double hole, int steps) {
  Outline outline;
  arc(outline, outer, kPi, std::asin(hole / outer), steps);
  Stl stl;
  if (hole == 0.0) revolve(outline, 2 * steps, stl), outline.clear();
  arc(outline, inner, std::asin(hole / inner), kPi, steps);
  revolve(outline, 2 * steps, stl);
  return checked(stl);
}

/// A round block of this radius, its top at z = 0, with a blind hole about z.
inline CheckedMesh blind_hole(double block, double hole, double depth, int segments) {
  Stl stl;
  revolve({{0, -depth - 10}, {block, -depth - 10}, {block, 0}, {hole, 0}, {hole, -depth}, {0, -depth}},
          segments, stl);
  return checked(stl);
}

/// A bar along y, -length/2 to length/2, its top at z = 0, with a slot of this width along it.
inline CheckedMesh slotted_bar(double width, double depth, double bar_width, double length) {
  const double w = width / 2, b = bar_width / 2, bottom = -depth - 10;
  const std::vector<std::array<double, 2>> ring{{-b, bottom}, {b, bottom},  {b, 0},  {w, 0},
                                                {w, -depth},  {-w, -depth}, {-w, 0}, {-b, 0}};
  const auto at = [&](int i, double y) { return Point<Part>{ring[i % 8][0], y, ring[i % 8][1]}; };
  Stl stl;
  const double near = -length / 2, far = length / 2;
  for (int i = 0; i < 8; ++i) {
    stl.facets.push_back({at(i, near), at(i + 1, near), at(i + 1, far)});
    stl.facets.push_back({at(i, near), at(i + 1, far), at(i, far)});
  }
  // The U of the ends, cut up so that every edge of the ring is a facet's.
  for (const auto& [i, j, k] : {std::array{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {0, 4, 5}, {0, 5, 7}, {5, 6, 7}}) {
    stl.facets.push_back({at(i, far), at(j, far), at(k, far)});
    stl.facets.push_back({at(i, near), at(k, near), at(j, near)});
  }
  for (auto& f : stl.facets) std::swap(f[1], f[2]);
  return checked(stl);
}

}  // namespace tiltfeed
