#include "pathgen/pattern/level_grid.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "pathgen/pattern/row_layout.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

namespace {

/// A coordinate is covered all round when so little of its turn is missing (share).
constexpr double kWholeTurn = 1e-9;

GridAxis grid_axis(double low, double high, double spacing, double period) {
  GridAxis axis;
  axis.wraps = period > 0.0 && high - low >= period * (1.0 - kWholeTurn);
  axis.cells = static_cast<int>(std::max(3.0, std::ceil((high - low) / spacing)));
  axis.step = std::max((high - low) / axis.cells, spacing * 1e-3);
  axis.low = low;
  if (!axis.wraps) axis.low -= axis.step, axis.cells += 2;
  return axis;
}

/// From low to high, without what is more than kCellsBeyond cells off the window; all of it where a seam is
/// nearer than that to the window.
void narrow(double& low, double& high, double window_low, double window_high, double spacing, double period) {
  const double from = window_low - kCellsBeyond * spacing, to = window_high + kCellsBeyond * spacing;
  if (!(window_low <= window_high) || (period > 0.0 && (from <= -period / 2.0 || to >= period / 2.0))) return;
  if (from > high || to < low) return;
  low = std::max(low, from), high = std::min(high, to);
}

double area(const FlatBounds& b, double spacing) {
  return std::max(b.max_x - b.min_x, spacing) * std::max(b.max_y - b.min_y, spacing);
}

}  // namespace

Result<LevelGrid> make_level_grid(const ClField& field, double spacing, const EnvelopeOptions& options,
                                  const std::optional<FlatBounds>& window, const Progress& progress) {
  const FlatBounds& all = field.index.bounds();
  FlatBounds b = all;
  if (window) {
    narrow(b.min_x, b.max_x, window->min_x, window->max_x, spacing, field.deformation.period_x());
    narrow(b.min_y, b.max_y, window->min_y, window->max_y, spacing, field.deformation.period_y());
  }
  const double nodes = (b.max_x - b.min_x) / spacing * ((b.max_y - b.min_y) / spacing);
  const double crossings =
      (field.index.crossings(1.0, 0.0, spacing) + field.index.crossings(0.0, 1.0, spacing)) *
      (area(b, spacing) / area(all, spacing));
  if (nodes > kMaxGridNodes || crossings > kMaxCrossings)
    return fail(Code::kLimit, "contours are found on grid lines " + std::to_string(spacing) +
                                  " mm apart, which is too fine for a surface of " +
                                  std::to_string(b.max_x - b.min_x) + " by " +
                                  std::to_string(b.max_y - b.min_y) +
                                  " mm: use a larger pattern.side_step_mm and pattern.step_down_mm");
  LevelGrid grid;
  grid.x = grid_axis(b.min_x, b.max_x, spacing, field.deformation.period_x());
  grid.y = grid_axis(b.min_y, b.max_y, spacing, field.deformation.period_y());
  const int rows = grid.y.nodes(), columns = grid.x.nodes();
  grid.node_heights.assign(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), kNoSurface);
  grid.rows.resize(static_cast<std::size_t>(rows));
  grid.columns.resize(static_cast<std::size_t>(columns));
  tbb::enumerable_thread_specific<Heights> heights([&] { return Heights(field, options); });
  const auto outermost = [](const GridAxis& axis, int k) {
    return !axis.wraps && (k == 0 || k == axis.cells);
  };
  const auto trace = [&](int k) {
    if (k >= rows) {
      const int i = k - rows;
      if (outermost(grid.x, i)) return;
      grid.columns[static_cast<std::size_t>(i)] =
          heights.local().profile({grid.x.at(i), grid.y.low, 0.0, 1.0, grid.y.step * grid.y.cells});
      return;
    }
    if (outermost(grid.y, k)) return;
    grid.rows[static_cast<std::size_t>(k)] =
        heights.local().profile({grid.x.low, grid.y.at(k), 1.0, 0.0, grid.x.step * grid.x.cells});
    for (int i = 0; i < columns; ++i)
      if (!outermost(grid.x, i))
        grid.node_heights[static_cast<std::size_t>(grid.node(i, k))] =
            heights.local().at({grid.x.at(i), grid.y.at(k)});
  };
  constexpr int kLinesPerReport = 64;
  for (int from = 0; from < rows + columns; from += kLinesPerReport) {
    const int to = std::min(from + kLinesPerReport, rows + columns);
    tbb::parallel_for(from, to, trace);
    if (progress && !progress("grid", static_cast<double>(to) / (rows + columns))) return cancelled();
  }
  return grid;
}

}  // namespace tiltfeed::pathgen
