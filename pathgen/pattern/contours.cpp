#include "pathgen/pattern/contours.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "pathgen/pattern/contour_order.h"
#include "pathgen/pattern/contour_trace.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

namespace {

/// Crossings of the grid lines are found this closely, as a share of the tolerance.
constexpr double kCrossingShare = 0.125;
/// Fewest tolerances between two grid lines.
constexpr double kLeastSpacing = 16.0;
/// Steps that round up to one more only by rounding (share of a step).
constexpr double kWholeStep = 1e-9;
/// Contours are followed so far beyond the window, cells: two crossings next to each other, of which both lie
/// further off, have nothing of it between them, and the border of the grid is further off still.
constexpr double kCellsWanted = 3.0;
/// Loops between two calls of the progress function.
constexpr std::size_t kLoopsPerReport = 16;

/// The window and so many cells more.
std::optional<FlatBox> about(const std::optional<FlatBounds>& window, const LevelGrid& grid, double cells) {
  if (!window) return std::nullopt;
  const double x = cells * grid.x.step, y = cells * grid.y.step;
  return FlatBox{window->min_x - x, window->max_x + x, window->min_y - y, window->max_y + y};
}

/// Lowest and highest finite z' on the grid lines, inside the boundary and the window.
Interval heights_of(const LevelGrid& grid, const FlatPolygon& boundary,
                    const std::optional<FlatBox>& window) {
  Interval span{kShut, kNoSurface};
  const auto take = [&](double x, double y, double z) {
    if (!std::isfinite(z) || (z >= span.low && z <= span.high) || !in_polygon(boundary, x, y)) return;
    if (window && !window->holds(x, y)) return;
    span.low = std::min(span.low, z), span.high = std::max(span.high, z);
  };
  for (std::size_t j = 0; j < grid.rows.size(); ++j)
    for (const HeightSample& s : grid.rows[j]) take(grid.x.low + s.run, grid.y.at(static_cast<int>(j)), s.z);
  for (std::size_t i = 0; i < grid.columns.size(); ++i)
    for (const HeightSample& s : grid.columns[i])
      take(grid.x.at(static_cast<int>(i)), grid.y.low + s.run, s.z);
  return span;
}

/// The levels' contours, one stage after the other.
class ZLevels {
 public:
  ZLevels(const ClField& field, const ContourOptions& options, const Progress& progress)
      : options_(options),
        map_(field.deformation),
        progress_(progress),
        tolerance_(options.envelope.tolerance),
        places_(field.index.tree(field.deformation)),
        heights_([this, &field, &options] {
          Heights heights(field, options.envelope);
          heights.envelope().look_up_in(places_);
          return heights;
        }) {}

  Result<Contours> run(const LevelGrid& grid) {
    const Interval surface = heights_of(grid, options_.boundary, about(options_.window, grid, 1.0));
    wanted_ = about(options_.window, grid, kCellsWanted);
    if (!(surface.low <= surface.high))
      return fail(Code::kUnreachable, "there is no surface inside the containment: check containment");
    const double top = std::min(surface.high, options_.height.high);
    const double bottom = std::isfinite(options_.height.low) ? options_.height.low : surface.low;
    auto levels = levels_between(top, bottom, options_.pattern.step_down);
    if (!levels) return tl::unexpected(levels.error());
    levels_ = std::move(*levels);
    if (static_cast<double>(grid.node_heights.size()) * static_cast<double>(levels_.size()) > kMaxLevelNodes)
      return fail(Code::kLimit, std::to_string(levels_.size()) + " levels on a grid of " +
                                    std::to_string(grid.node_heights.size()) +
                                    " places need more memory than is set aside; use a larger " + steps());
    if (!find(grid) || !trace()) return cancelled();
    return collect();
  }

 private:
  bool report(const char* stage, std::size_t done, std::size_t of) const {
    return !progress_ || progress_(stage, static_cast<double>(done) / static_cast<double>(of));
  }

  /// The keys that the grid's spacing comes from.
  std::string steps() const {
    const bool levels_only = options_.pattern.kind == PatternKind::kZLevel;
    return levels_only ? "pattern.step_down_mm" : "pattern.step_down_mm or pattern.side_step_mm";
  }

  bool find(const LevelGrid& grid) {
    std::vector<std::unique_ptr<LevelSet>> found(levels_.size());
    for (std::size_t from = 0; from < levels_.size(); from += 16) {
      const std::size_t to = std::min(from + 16, levels_.size());
      tbb::parallel_for(from, to, [&](std::size_t k) {
        found[k] = std::make_unique<LevelSet>(grid, levels_[k] + tolerance_ * kRiseShare, heights_.local(),
                                              tolerance_ * kCrossingShare);
      });
      if (!report("levels", to, levels_.size())) return false;
    }
    for (auto& set : found) sets_.push_back(std::move(*set));
    return true;
  }

  bool trace() {
    std::vector<LoopId> all;
    for (std::size_t k = 0; k < sets_.size(); ++k) {
      traces_.emplace_back(sets_[k].loops().size());
      for (std::size_t l = 0; l < sets_[k].loops().size(); ++l)
        all.push_back({static_cast<int>(k), static_cast<int>(l)});
    }
    for (std::size_t from = 0; from < all.size(); from += kLoopsPerReport) {
      const std::size_t to = std::min(from + kLoopsPerReport, all.size());
      tbb::parallel_for(from, to, [&](std::size_t i) {
        const auto k = static_cast<std::size_t>(all[i].level), l = static_cast<std::size_t>(all[i].loop);
        const TraceOptions how{levels_[k], tolerance_, options_.envelope.max_axis_step,
                               options_.pattern.climb, wanted_};
        traces_[k][l] = trace_contour(sets_[k].loops()[l], how, heights_.local());
        traces_[k][l].passes = inside_polygon(traces_[k][l].passes, map_, options_.boundary);
      });
      if (!report("contours", to, all.size())) return false;
    }
    return true;
  }

  Contours collect() {
    Contours result;
    std::uint64_t left_out = 0;
    for (const std::vector<LoopId>& ids : order_of(sets_)) {
      std::vector<Pass> group;
      for (const LoopId id : ids) {
        Trace& trace = traces_[static_cast<std::size_t>(id.level)][static_cast<std::size_t>(id.loop)];
        left_out += trace.left_out;
        for (Pass& pass : trace.passes) {
          if (!group.empty()) start_near(pass, group.back().back().centre);
          group.push_back(std::move(pass));
        }
      }
      if (!group.empty()) result.groups.push_back(std::move(group));
    }
    if (left_out > 0)
      result.warnings.push_back(std::to_string(left_out) +
                                " moves of contours left out: between two grid lines the surface rises over "
                                "them or falls away; a smaller " +
                                steps() + " may follow it");
    return result;
  }

  const ContourOptions& options_;
  const Deformation& map_;
  const Progress& progress_;
  double tolerance_;
  HullBvh places_;  ///< contours ask here and there
  tbb::enumerable_thread_specific<Heights> heights_;
  std::vector<double> levels_;
  std::optional<FlatBox> wanted_;           ///< contours are followed there alone
  std::vector<LevelSet> sets_;              ///< by level
  std::vector<std::vector<Trace>> traces_;  ///< by level and loop
};

}  // namespace

double grid_spacing(const Pattern& pattern, double tolerance) {
  double spacing = pattern.step_down;
  if (pattern.side_step > 0.0 && (spacing <= 0.0 || pattern.side_step < spacing)) spacing = pattern.side_step;
  return std::max(spacing, kLeastSpacing * tolerance);
}

Result<std::vector<double>> levels_between(double top, double bottom, double step_down) {
  if (!(step_down > 0.0) || !std::isfinite(step_down))
    return fail(Code::kInput, "pattern.step_down_mm must be a positive length");
  if (!(bottom <= top)) return fail(Code::kUnreachable, "the containment lies above the whole surface");
  const double count = std::max(1.0, std::ceil((top - bottom) / step_down - kWholeStep));
  if (count > kMaxLevels)
    return fail(Code::kLimit, "pattern.step_down_mm of " + std::to_string(step_down) +
                                  " asks for more than " + std::to_string(static_cast<int>(kMaxLevels)) +
                                  " levels over " + std::to_string(top - bottom) + " mm; use a larger step");
  std::vector<double> levels;
  for (double k = 1.0; k <= count; ++k) levels.push_back(top + (bottom - top) * (k / count));
  return levels;
}

Result<Contours> z_level(const ClField& field, const ContourOptions& options, const Progress& progress) {
  const double spacing = grid_spacing(options.pattern, options.envelope.tolerance);
  const auto grid = make_level_grid(field, spacing, options.envelope, options.window, progress);
  if (!grid) return tl::unexpected(grid.error());
  return ZLevels(field, options, progress).run(*grid);
}

}  // namespace tiltfeed::pathgen
