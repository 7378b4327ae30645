#include "pathgen/creases/crease_graph.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "kinematics/basics/geometry.h"
#include "pathgen/surface/hull_bvh.h"

namespace tiltfeed::pathgen {

namespace {

constexpr std::size_t kRowsPerLook = 32;
constexpr int kMostTraceHalvings = 24;
/// No crease climbs by more in kLeastCreaseCell, mm.
constexpr double kMostClimb = 0.1;
/// Of the spacing: the grid stands aside of where parts mostly have their edges.
constexpr double kOffGrid = 0.3819660112501051;

/// What one thread asks.
struct CreaseSight {
  CreaseSight(const ClField& field, const HullBvh& places, const CreaseOptions& options)
      : along_lines(field.surface, field.deformation, field.index, options.envelope),
        at_places(along_lines),
        on_lines(field, along_lines, options.kinks),
        on_short(field, at_places, options.kinks) {
    at_places.look_up_in(places);
  }
  CreaseSight(const CreaseSight&) = delete;
  CreaseSight& operator=(const CreaseSight&) = delete;
  Envelope along_lines, at_places;
  KinkSearch on_lines, on_short;
};

/// A node on the border of a cell.
struct BorderNode {
  std::uint32_t node = 0;
  int side = 0;  ///< 0 low y, 1 high x, 2 high y, 3 low x
};

/// One cell of the grid: its nodes beyond those of the grid's lines, and its pieces.
class CreaseCell {
 public:
  CreaseCell(const std::vector<CreaseNode>& grid, KinkSearch& kinks, const CreaseOptions& options)
      : grid_(grid), kinks_(kinks), options_(options) {}

  void solve(const FlatBox& box, const std::vector<BorderNode>& border) {
    if (border.empty()) return;
    const bool is_least = std::max(box.high_x - box.low_x, box.high_y - box.low_y) <= kLeastCreaseCell;
    if (border.size() == 2) {
      const std::size_t nodes = own.size(), count = pieces.size();
      if (trace(border[0].node, border[1].node, 0)) return;
      own.resize(nodes), pieces.resize(count);
    }
    if (is_least) {
      meet(border);
      return;
    }
    quarter(box, border);
  }

  std::vector<CreaseNode> own;  ///< numbered on from those of the grid
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pieces;

 private:
  const CreaseNode& node(std::uint32_t k) const {
    return k < grid_.size() ? grid_[k] : own[k - grid_.size()];
  }
  std::uint32_t add(const Kink& kink) {
    own.push_back({kink.point, kink.aside, kink.steep});
    return static_cast<std::uint32_t>(grid_.size() + own.size() - 1);
  }

  /// What is left of creases meets. Beside a wall along the axis the foot of it and its top do not.
  void meet(const std::vector<BorderNode>& border) {
    for (std::size_t k = 1; k < border.size(); ++k)
      for (std::size_t j = 0; j < k; ++j)
        if (near(border[j].node, border[k].node)) {
          pieces.emplace_back(border[j].node, border[k].node);
          break;
        }
  }
  bool near(std::uint32_t a, std::uint32_t b) const {
    return distance(node(a).point.centre, node(b).point.centre) <= kMostClimb;
  }

  /// Halves the way from a to b until the crease lies on it; false where it does not go on.
  bool trace(std::uint32_t a, std::uint32_t b, int depth) {
    const EnvelopePoint p = node(a).point, q = node(b).point;
    const double dx = q.flat.x - p.flat.x, dy = q.flat.y - p.flat.y, apart = std::hypot(dx, dy);
    if (distance(p.centre, q.centre) <= options_.chord || apart <= 4.0 * kKinkStep ||
        depth >= kMostTraceHalvings) {
      if (!near(a, b)) return false;
      pieces.emplace_back(a, b);
      return true;
    }
    const double x = 0.5 * (p.flat.x + q.flat.x), y = 0.5 * (p.flat.y + q.flat.y);
    const FlatLine across{x + dy, y - dx, -dy / apart, dx / apart, 2.0 * apart};
    const std::vector<Kink> found = kinks_.along(across);
    const auto nearer = [&](const Kink& k, const Kink& l) {
      return std::abs(k.run - apart) < std::abs(l.run - apart);
    };
    const auto kink = std::min_element(found.begin(), found.end(), nearer);
    if (kink == found.end()) return false;
    const std::uint32_t middle = add(*kink);
    // Two halvings at least: an S has its middle on the chord.
    if (depth >= 1 && distance_to_segment(kink->point.centre, p.centre, q.centre) <= options_.chord) {
      pieces.emplace_back(a, middle), pieces.emplace_back(middle, b);
      return true;
    }
    return trace(a, middle, depth + 1) && trace(middle, b, depth + 1);
  }

  void quarter(const FlatBox& box, const std::vector<BorderNode>& border) {
    const double x = 0.5 * (box.low_x + box.high_x), y = 0.5 * (box.low_y + box.high_y);
    std::array<std::vector<BorderNode>, 4> quarters;  // by x, then y
    for (const BorderNode& b : border) {
      const Point<Flat> f = node(b.node).point.flat;
      const bool high_x = b.side == 1 || (b.side != 3 && f.x >= x);
      const bool high_y = b.side == 2 || (b.side != 0 && f.y >= y);
      quarters[(high_x ? 1 : 0) + (high_y ? 2 : 0)].push_back(b);
    }
    for (const Kink& kink : kinks_.along({x, box.low_y, 0.0, 1.0, box.high_y - box.low_y})) {
      const std::size_t high = box.low_y + kink.run >= y ? 2 : 0;
      const std::uint32_t k = add(kink);
      quarters[high].push_back({k, 1}), quarters[high + 1].push_back({k, 3});
    }
    for (const Kink& kink : kinks_.along({box.low_x, y, 1.0, 0.0, box.high_x - box.low_x})) {
      const std::size_t high = box.low_x + kink.run >= x ? 1 : 0;
      const std::uint32_t k = add(kink);
      quarters[high].push_back({k, 2}), quarters[high + 2].push_back({k, 0});
    }
    solve({box.low_x, x, box.low_y, y}, quarters[0]);
    solve({x, box.high_x, box.low_y, y}, quarters[1]);
    solve({box.low_x, x, y, box.high_y}, quarters[2]);
    solve({x, box.high_x, y, box.high_y}, quarters[3]);
  }

  const std::vector<CreaseNode>& grid_;
  KinkSearch& kinks_;
  const CreaseOptions& options_;
};

/// The grid's lines, and what was found on them.
class CreaseGrid {
 public:
  CreaseGrid(const ClField& field, const FlatBounds& bounds, const CreaseOptions& options)
      : options_(options),
        places_(field.index.tree(field.deformation)),
        sights_([this, &field] { return std::make_unique<CreaseSight>(field, places_, options_); }) {
    const auto lines = [&](double low, double high) {
      std::vector<double> at{low};
      for (double v = low + options_.spacing * kOffGrid; v < high; v += options_.spacing) at.push_back(v);
      at.push_back(high);
      return at;
    };
    x_ = lines(bounds.min_x, bounds.max_x), y_ = lines(bounds.min_y, bounds.max_y);
  }

  Result<CreaseGraph> run(const Progress& progress) {
    std::vector<std::vector<Kink>> found(x_.size() + y_.size());
    const auto look = [&](std::size_t k) {
      KinkSearch& kinks = sights_.local()->on_lines;
      if (k < y_.size()) {
        found[k] = kinks.along({x_.front(), y_[k], 1.0, 0.0, x_.back() - x_.front()});
      } else {
        found[k] = kinks.along({x_[k - y_.size()], y_.front(), 0.0, 1.0, y_.back() - y_.front()});
      }
    };
    if (!each("lines", found.size(), look, progress)) return cancelled();
    borders_.resize((x_.size() - 1) * (y_.size() - 1));
    for (std::size_t k = 0; k < found.size(); ++k)
      for (const Kink& kink : found[k]) put(k, kink);
    std::vector<std::unique_ptr<CreaseCell>> cells(borders_.size());
    const std::size_t columns = x_.size() - 1;
    const auto solve_row = [&](std::size_t row) {
      for (std::size_t c = row * columns; c < (row + 1) * columns; ++c) {
        if (borders_[c].empty()) continue;
        cells[c] = std::make_unique<CreaseCell>(graph_.nodes, sights_.local()->on_short, options_);
        const std::size_t i = c % columns;
        cells[c]->solve({x_[i], x_[i + 1], y_[row], y_[row + 1]}, borders_[c]);
      }
    };
    if (!each("creases", y_.size() - 1, solve_row, progress)) return cancelled();
    const auto of_grid = static_cast<std::uint32_t>(graph_.nodes.size());
    for (const auto& cell : cells) {
      if (!cell) continue;
      const auto shift = static_cast<std::uint32_t>(graph_.nodes.size()) - of_grid;
      const auto number = [&](std::uint32_t k) { return k < of_grid ? k : k + shift; };
      for (const auto& [a, b] : cell->pieces) graph_.pieces.emplace_back(number(a), number(b));
      graph_.nodes.insert(graph_.nodes.end(), cell->own.begin(), cell->own.end());
    }
    return std::move(graph_);
  }

 private:
  /// Calls work(0)..work(count - 1) on all threads; false when the user wants no more.
  template <class Work>
  static bool each(const char* stage, std::size_t count, const Work& work, const Progress& progress) {
    for (std::size_t from = 0; from < count; from += kRowsPerLook) {
      const std::size_t to = std::min(from + kRowsPerLook, count);
      tbb::parallel_for(from, to, work);
      if (progress && !progress(stage, static_cast<double>(to) / static_cast<double>(count))) return false;
    }
    return true;
  }

  /// A kink of a line goes to the cells on both sides.
  void put(std::size_t line, const Kink& kink) {
    const auto node = static_cast<std::uint32_t>(graph_.nodes.size());
    graph_.nodes.push_back({kink.point, kink.aside, kink.steep});
    const auto interval = [](const std::vector<double>& at, double v) {
      const auto next = std::upper_bound(at.begin() + 1, at.end() - 1, v);
      return static_cast<std::size_t>(next - at.begin()) - 1;
    };
    const std::size_t columns = x_.size() - 1, rows = y_.size() - 1;
    if (line < y_.size()) {
      const std::size_t i = interval(x_, x_.front() + kink.run);
      if (line > 0) borders_[(line - 1) * columns + i].push_back({node, 2});
      if (line < rows) borders_[line * columns + i].push_back({node, 0});
      return;
    }
    const std::size_t i = line - y_.size(), j = interval(y_, y_.front() + kink.run);
    if (i > 0) borders_[j * columns + i - 1].push_back({node, 1});
    if (i < columns) borders_[j * columns + i].push_back({node, 3});
  }

  CreaseOptions options_;
  HullBvh places_;
  tbb::enumerable_thread_specific<std::unique_ptr<CreaseSight>> sights_;
  std::vector<double> x_, y_;
  std::vector<std::vector<BorderNode>> borders_;  ///< by cell, row by row
  CreaseGraph graph_;
};

}  // namespace

Result<CreaseGraph> trace_crease_graph(const ClField& field, const FlatBounds& bounds,
                                       const CreaseOptions& options, const Progress& progress) {
  const double most = std::max(bounds.max_x - bounds.min_x, bounds.max_y - bounds.min_y);
  if (!(bounds.min_x < bounds.max_x && bounds.min_y < bounds.max_y)) return CreaseGraph{};
  if (!(most <= kMostCreaseLines * options.spacing))
    return fail(Code::kLimit, "creases are looked for on lines " + std::to_string(options.spacing) +
                                  " mm apart, a quarter of the cutter's diameter: over " +
                                  std::to_string(most) +
                                  " mm those are too many; use a containment or a larger cutter");
  return CreaseGrid(field, bounds, options).run(progress);
}

}  // namespace tiltfeed::pathgen
