#pragma once
// Parts made in flat space and bent by the map of an axis mode, so that one profile with sharp steps, walls
// along the tool axis, a ridge, a groove, a steep rib and waves can be proved in every mode.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed {
using namespace pathgen;

inline constexpr double kGroundRadius = 40.0;  ///< of the slab's ground from the axis feature, mm
inline constexpr double kBack = 4.0;           ///< thickness below the ground, mm
inline constexpr double kTubeRadius = 30.0;
inline constexpr double kPartWidth = 24.0, kDepth = 20.0, kCell = 0.8;

struct Ground {
  double at, height;
};

/// Along u; two rows at one place are a wall along the tool axis.
inline const std::vector<Ground> kAlongU{
    {0, 0},      {4, 0},      {4, 2},      {7, 2},      {7, 0.5},  // a step, a groove's edge
    {10, 0.5},   {11.5, 3.1}, {13.5, 1.1},                         // 60 and 45 degrees to a ridge
    {15, -0.9},  {17, 1.1},                                        // a V-groove
    {17.5, 1.3}, {18.5, 1.8}, {19.5, 2.1}, {20.5, 2.0}, {22, 1.2}, {kPartWidth, 0.3}  // a bump
};
/// Along v, added: a rib with walls of 72 degrees, then a ramp.
inline const std::vector<Ground> kAlongV{{0, 0.3},  {8, 0},  {8.4, 1.23},  {10, 1.23},
                                         {10.4, 0}, {14, 0}, {kDepth, 0.8}};

/// The rows, and more between them so that no cell is wider than kCell.
inline std::vector<Ground> refined(const std::vector<Ground>& rows) {
  std::vector<Ground> fine{rows.front()};
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Ground &a = rows[i - 1], &b = rows[i];
    const int cells = std::max(1, static_cast<int>(std::ceil((b.at - a.at) / kCell)));
    for (int k = 1; k <= cells; ++k) {
      const double f = static_cast<double>(k) / cells;
      fine.push_back({a.at + f * (b.at - a.at), a.height + f * (b.height - a.height)});
    }
  }
  return fine;
}

/// A surface over a grid and its back, in rows i and columns j.
struct Shell {
  std::function<Point<Part>(std::size_t i, std::size_t j, bool top)> at;
  Stl stl;

  void quad(Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
    if (!(a == b || b == c || c == a)) stl.facets.push_back({a, b, c});
    if (!(a == c || c == d || d == a)) stl.facets.push_back({a, c, d});
  }
  void faces(std::size_t rows, std::size_t columns) {
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j) {
        quad(at(i, j, true), at(i + 1, j, true), at(i + 1, j + 1, true), at(i, j + 1, true));
        quad(at(i, j, false), at(i, j + 1, false), at(i + 1, j + 1, false), at(i + 1, j, false));
      }
  }
  void end(std::size_t i, std::size_t from, std::size_t to) {
    quad(at(i, from, false), at(i, to, false), at(i, to, true), at(i, from, true));
  }
  void side(std::size_t from, std::size_t to, std::size_t j) {
    quad(at(from, j, false), at(to, j, false), at(to, j, true), at(from, j, true));
  }
  CheckedMesh checked() const {
    auto mesh = check_mesh(stl);
    EXPECT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->sides, Sides::kOutward);
    EXPECT_GT(mesh->volume, 0.0);
    return *mesh;
  }
};

/// The slab in flat space, bent by the map: closed, normals out of the material.
inline CheckedMesh slab(const AxisFrame& axis) {
  const Deformation map(axis, kGroundRadius);
  const double level = axis.mode == AxisMode::kFixed ? 0.0 : map.s() * kGroundRadius;
  const auto us = refined(kAlongU), vs = refined(kAlongV);
  const std::size_t m = us.size() - 1, n = vs.size() - 1;
  Shell shell;
  shell.at = [&](std::size_t i, std::size_t j, bool top) {
    const double u = us[i].at - kPartWidth / 2, v = vs[j].at - kDepth / 2;
    const double height = us[i].height + vs[j].height + 0.25 * std::sin(0.9 * u) * std::cos(0.5 * v);
    return map.unflatten({u, v, level + (top ? height : -kBack)});
  };
  shell.faces(m, n);
  for (std::size_t j = 0; j < n; ++j) shell.end(0, j + 1, j), shell.end(m, j, j + 1);
  for (std::size_t i = 0; i < m; ++i) shell.side(i, i + 1, 0), shell.side(i + 1, i, n);
  return shell.checked();
}

/// The same rows along a line, turned right round it: a shaft, or a bore.
inline CheckedMesh tube(const AxisFrame& axis) {
  const Deformation map(axis, kTubeRadius);
  const auto us = refined(kAlongU);
  constexpr std::size_t kColumns = 90;
  const std::size_t m = us.size() - 1;
  Shell shell;
  shell.at = [&](std::size_t i, std::size_t j, bool top) {
    const double theta = 2.0 * kPi * static_cast<double>(j % kColumns) / kColumns;
    const double height = 0.7 * us[i].height + 0.8 * std::cos(5.0 * theta);
    return map.unflatten(
        {us[i].at - kPartWidth / 2, kTubeRadius * theta, map.s() * kTubeRadius + (top ? height : -kBack)});
  };
  shell.faces(m, kColumns);
  for (std::size_t j = 0; j < kColumns; ++j) shell.end(0, j + 1, j), shell.end(m, j, j + 1);
  return shell.checked();
}

}  // namespace tiltfeed
