#pragma once
// What the tests of passes share: sheets over a grid in any axis mode, solids turned about z, the passes of a
// tool path, and distances from them by brute force.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "pathgen/plan/plan.h"
#include "tests/shapes/bent_parts.h"

namespace tiltfeed {
using namespace pathgen;

inline constexpr AxisFrame kUpright{AxisMode::kFixed, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};
inline constexpr AxisFrame kPointFrame{AxisMode::kPoint, Sense::kOutward, {0, 0, 0},
                                       {1, 0, 0},        {0, 1, 0},       0.0};
inline constexpr AxisFrame kRing{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 60.0};

/// A grid in the axis mode's own coordinates (mm or rad).
struct Grid {
  double u0, u1, v0, v1;
  int columns, rows;
};

/// The closed sheet with its top at z' = top(u, v), kBack thick along the axis.
inline CheckedMesh sheet(const AxisFrame& axis, const Grid& g,
                         const std::function<double(double, double)>& top) {
  const Deformation map(axis, 1.0);
  Shell shell;
  shell.at = [&](std::size_t i, std::size_t j, bool upper) {
    const double u = g.u0 + (g.u1 - g.u0) * static_cast<double>(i) / g.columns;
    const double v = g.v0 + (g.v1 - g.v0) * static_cast<double>(j) / g.rows;
    return map.unflatten({u * map.scale_x(), v * map.scale_y(), top(u, v) - (upper ? 0.0 : kBack)});
  };
  const auto m = static_cast<std::size_t>(g.columns), n = static_cast<std::size_t>(g.rows);
  shell.faces(m, n);
  for (std::size_t j = 0; j < n; ++j) shell.end(0, j + 1, j), shell.end(m, j, j + 1);
  for (std::size_t i = 0; i < m; ++i) shell.side(i, i + 1, 0), shell.side(i + 1, i, n);
  return shell.checked();
}

/// (radius, height) from the axis' upper end down to its lower end, turned about z.
inline CheckedMesh turned(const std::vector<std::array<double, 2>>& profile, std::size_t columns) {
  Shell shell;
  const auto at = [&](std::size_t i, std::size_t j) {
    const double angle = 2.0 * kPi * static_cast<double>(j % columns) / static_cast<double>(columns);
    return Point<Part>{profile[i][0] * std::cos(angle), profile[i][0] * std::sin(angle), profile[i][1]};
  };
  for (std::size_t i = 0; i + 1 < profile.size(); ++i)
    for (std::size_t j = 0; j < columns; ++j)
      shell.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  return shell.checked();
}

inline PlanOptions options_with(const AxisFrame& axis) {
  PlanOptions o;
  o.name = "test";
  o.cutter = {4.0, 100.0, 30.0};
  o.axis = axis;
  o.pattern.side_step = 1.5;
  o.links.clearance = 4.0;
  o.links.approach = 1.0;
  o.cut_feed = Feed::from_mm_per_min(1000);
  o.plunge_feed = Feed::from_mm_per_min(300);
  return o;
}

/// Poses of one unbroken run of cutting moves, its start included.
using CutRun = std::vector<Pose>;

inline std::vector<CutRun> runs_of(const ToolPath& path) {
  std::vector<CutRun> runs;
  for (std::size_t i = 1; i < path.moves.size(); ++i) {
    if (path.moves[i].kind != MoveKind::kCut) continue;
    if (path.moves[i - 1].kind != MoveKind::kCut) runs.push_back({path.moves[i - 1].pose});
    runs.back().push_back(path.moves[i].pose);
  }
  return runs;
}

inline std::vector<CutRun> runs_of(const CheckedMesh& part, const PlanOptions& options) {
  const auto planned = plan(part, options, nullptr);
  EXPECT_TRUE(planned) << planned.error().message;
  return planned ? runs_of(planned->path) : std::vector<CutRun>{};
}

/// The runs with points at most `spacing` apart, axes turned evenly.
inline std::vector<CutRun> dense(const std::vector<CutRun>& runs, double spacing) {
  std::vector<CutRun> finer;
  for (const CutRun& run : runs) {
    finer.push_back({run.front()});
    for (std::size_t i = 1; i < run.size(); ++i) {
      const double size = distance(run[i - 1].tip, run[i].tip);
      const int steps = std::max(1, static_cast<int>(std::ceil(size / spacing)));
      for (int k = 1; k <= steps; ++k) {
        const double f = static_cast<double>(k) / steps;
        finer.back().push_back(
            {lerp(run[i - 1].tip, run[i].tip, f), normalized(run[i - 1].axis * (1.0 - f) + run[i].axis * f)});
      }
    }
  }
  return finer;
}

/// Distance of p from the nearest move, without those of run `but`.
inline double from_runs(Point<Part> p, const std::vector<CutRun>& runs, const CutRun* but = nullptr) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const CutRun& run : runs)
    for (std::size_t i = 1; i < run.size() && &run != but; ++i)
      nearest = std::min(nearest, distance_to_segment(p, run[i - 1].tip, run[i].tip));
  return nearest;
}

inline double median(std::vector<double> values) {
  EXPECT_FALSE(values.empty());
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace tiltfeed
