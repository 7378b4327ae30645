#pragma once
// Boxes of the flat plane, found by the places and lines that meet them: grids of bins, one for each size of
// box. (S6) in pathgen/surface/README.md.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pathgen/mesh/fresh_memory.h"

namespace tiltfeed::pathgen {

/// A straight line of flat space, from (x, y) along the unit direction (dx, dy); the run coordinate is the
/// distance from its start. Where a coordinate wraps, the line may run past the seam by up to a turn.
struct FlatLine {
  double x = 0.0, y = 0.0;
  double dx = 1.0, dy = 0.0;
  double length = 0.0;  ///< mm
  double x_at(double run) const { return x + dx * run; }
  double y_at(double run) const { return y + dy * run; }
  double run_of(double at_x, double at_y) const { return (at_x - x) * dx + (at_y - y) * dy; }
  /// How far to the left of the origin it passes, mm.
  double across() const { return y * dx - x * dy; }
};

/// The rectangle that holds every hull; a coordinate that wraps and is covered past its seam has its full
/// turn.
struct FlatBounds {
  double min_x = 0.0, max_x = 0.0, min_y = 0.0, max_y = 0.0;
};

/// A rectangle of the flat plane; may lie past a seam.
struct FlatBox {
  double low_x = 0.0, high_x = 0.0, low_y = 0.0, high_y = 0.0;
  bool holds(double x, double y) const { return x >= low_x && x <= high_x && y >= low_y && y <= high_y; }
  bool overlaps(const FlatBox& other) const {
    return low_x <= other.high_x && high_x >= other.low_x && low_y <= other.high_y && high_y >= other.low_y;
  }
};

/// The rectangle round a line.
inline FlatBox box_round(const FlatLine& line) {
  const double end_x = line.x_at(line.length), end_y = line.y_at(line.length);
  return {std::min(line.x, end_x), std::max(line.x, end_x), std::min(line.y, end_y), std::max(line.y, end_y)};
}

/// Where the line is in the box; false if nowhere.
bool run_in_box(const FlatBox& box, const FlatLine& line, double& from, double& to);

/// The same in half the memory, for a box that is only to be found.
struct LooseBox {
  float low_x = 0.0f, high_x = 0.0f, low_y = 0.0f, high_y = 0.0f;
};
/// The least that holds `box`.
LooseBox loosened(const FlatBox& box);

class FlatBins {
 public:
  FlatBins() = default;
  /// The boxes lie within `bounds`, but for what lies past a seam; where a coordinate wraps, its bounds are a
  /// whole turn. A period of 0: it does not wrap.
  FlatBins(std::span<const LooseBox> boxes, const FlatBounds& bounds, double period_x, double period_y);

  /// Calls visit(index) for each box that the line may meet, some more than once.
  template <class Visit>
  void each_on(const FlatLine& line, Visit visit) const {
    for (const Grid& grid : grids_) each_bin_on(grid, line, [&](std::size_t bin) { each_in(bin, visit); });
  }
  /// The same for each box that may overlap `box`.
  template <class Visit>
  void each_near(const FlatBox& box, Visit visit) const {
    for (const Grid& grid : grids_) each_bin(grid, box, [&](std::size_t bin) { each_in(bin, visit); });
  }
  /// Calls visit(index) for each box that may hold (x, y), the largest first, until it returns true; returns
  /// that.
  template <class Visit>
  bool any_at(double x, double y, Visit visit) const {
    for (auto grid = grids_.rbegin(); grid != grids_.rend(); ++grid) {
      const std::size_t bin = grid->bin(grid->x.wrapped(grid->x.bin(x)), grid->y.wrapped(grid->y.bin(y)));
      for (std::uint32_t e = start_[bin]; e < start_[bin + 1]; ++e)
        if (visit(entries_[e])) return true;
    }
    return false;
  }

  /// About the distance of neighbouring boxes, mm.
  double spacing() const { return spacing_; }

 private:
  /// One coordinate's bins.
  struct Axis {
    double low = 0.0, size = 1.0, per_size = 1.0;
    std::int64_t count = 1;
    bool wraps = false;
    std::int64_t bin(double value) const {
      const double at = (value - low) * per_size;
      const auto whole = static_cast<std::int64_t>(at);
      return whole - (at < static_cast<double>(whole) ? 1 : 0);
    }
    std::int64_t wrapped(std::int64_t bin) const { return bin >= 0 && bin < count ? bin : from_outside(bin); }
    std::int64_t from_outside(std::int64_t bin) const;
    void span(double from, double to, std::int64_t& first, std::int64_t& last) const;
  };
  struct Grid {
    Axis x, y;
    std::size_t first = 0;  ///< bin
    std::size_t bin(std::int64_t i, std::int64_t j) const {
      return first + static_cast<std::size_t>(j * x.count + i);
    }
  };
  void lay_grids(std::span<const LooseBox> boxes, const FlatBounds& bounds, double period_x, double period_y);
  void fill(std::span<const LooseBox> boxes);
  template <class Box, class Visit>
  static void each_bin(const Grid& grid, const Box& box, Visit visit) {
    std::int64_t i0, i1, j0, j1;
    grid.x.span(box.low_x, box.high_x, i0, i1);
    grid.y.span(box.low_y, box.high_y, j0, j1);
    for (std::int64_t j = j0; j <= j1; ++j)
      for (std::int64_t i = i0; i <= i1; ++i) visit(grid.bin(grid.x.wrapped(i), grid.y.wrapped(j)));
  }
  template <class Visit>
  static void each_bin_on(const Grid& grid, const FlatLine& line, Visit visit) {
    const std::int64_t pieces = pieces_of(grid, line);
    for (std::int64_t k = 0; k < pieces; ++k) each_bin(grid, piece_box(line, k, pieces), visit);
  }
  static std::int64_t pieces_of(const Grid& grid, const FlatLine& line);
  static FlatBox piece_box(const FlatLine& line, std::int64_t k, std::int64_t pieces);
  template <class Visit>
  void each_in(std::size_t bin, Visit visit) const {
    for (std::uint32_t e = start_[bin]; e < start_[bin + 1]; ++e) visit(entries_[e]);
  }

  std::vector<Grid> grids_;  ///< from fine to coarse
  double spacing_ = 0.0;
  FreshVector<std::uint8_t> grid_of_;  ///< by box
  std::vector<std::uint32_t> start_;   ///< of each bin in entries_
  FreshVector<std::uint32_t> entries_;
};

}  // namespace tiltfeed::pathgen
