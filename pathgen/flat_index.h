#pragma once
// Finds the patches that a straight line of the flat space can meet, and where along it: a grid of bins over
// the cells. (S6) in pathgen/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/cells.h"
#include "pathgen/deformation.h"

namespace tiltfeed {

/// A straight line of flat space, from (x, y) along the unit direction (dx, dy); the run coordinate is the
/// distance from its start. Where a coordinate wraps, the line may run past the seam by up to a turn.
struct FlatLine {
  double x = 0.0, y = 0.0;
  double dx = 1.0, dy = 0.0;
  double length = 0.0;  ///< mm
  double x_at(double run) const { return x + dx * run; }
  double y_at(double run) const { return y + dy * run; }
  double run_of(double at_x, double at_y) const { return (at_x - x) * dx + (at_y - y) * dy; }
};

/// Patch `patch` can be the highest only for run coordinates in [from, to].
struct Candidate {
  double from = 0.0, to = 0.0;
  PatchId patch = 0;
  float top = std::numeric_limits<float>::infinity();  ///< as Cell::top
};

/// The rectangle that holds every cell; a coordinate that wraps and is covered past its seam has its full
/// turn.
struct FlatBounds {
  double min_x = 0.0, max_x = 0.0, min_y = 0.0, max_y = 0.0;
};

class FlatIndex {
 public:
  /// Requires: at least one cell.
  FlatIndex(Cells cells, const Deformation& deformation);

  /// What one thread needs to ask; reused from question to question.
  struct Scratch {
    std::vector<std::uint32_t> seen;  ///< per cell: the question it was last seen in
    std::uint32_t question = 0;
    std::vector<Candidate> pieces;  ///< of patches with several cells
  };

  /// Properties: a patch that is the highest anywhere on the line is among the candidates there; intervals of
  /// one patch do not overlap; they are sorted by (from, patch, to) and lie within [0, line.length].
  void along(const FlatLine& line, Scratch& scratch, std::vector<Candidate>& candidates) const;

  /// Calls visit(patch) for each cell whose box holds (x, y), until it returns true; returns that.
  template <class Visit>
  bool any_at(double x, double y, Visit visit) const {
    const std::size_t bin =
        static_cast<std::size_t>(y_.wrapped(y_.bin(y)) * x_.count + x_.wrapped(x_.bin(x)));
    for (std::uint32_t e = start_[bin]; e < start_[bin + 1]; ++e)
      if (holds(cells_.cells[entries_[e]], x, y) && visit(cells_.cells[entries_[e]].patch)) return true;
    return false;
  }
  /// About how many cells lines in the direction (dx, dy), `step` apart, cut in all.
  double crossings(double dx, double dy, double step) const;

  const FlatBounds& bounds() const { return bounds_; }
  const std::vector<PatchId>& near() const { return cells_.near; }

 private:
  struct Box {
    double low_x, high_x, low_y, high_y;
  };
  /// One coordinate's bins.
  struct Axis {
    double low = 0.0, size = 1.0;
    std::int64_t count = 1;
    double period = 0.0;  ///< 0: does not wrap
    std::int64_t bin(double value) const;
    std::int64_t wrapped(std::int64_t bin) const;
  };
  Box box_of(const Cell& cell) const;
  bool holds(const Cell& cell, double x, double y) const;
  void find_bounds(const std::vector<Box>& boxes, const Deformation& deformation);
  void choose_bins(const std::vector<Box>& boxes);
  void fill_bins(const std::vector<Box>& boxes);
  bool has_siblings(std::uint32_t cell) const;
  template <class Visit>
  void each_bin(const Box& box, Visit visit) const;
  void add_cell(const Cell& cell, const FlatLine& line, const Box& swept,
                std::vector<Candidate>& candidates) const;

  Cells cells_;
  FlatBounds bounds_;
  Axis x_, y_;
  std::vector<std::uint32_t> start_;  ///< of each bin in entries_
  std::vector<std::uint32_t> entries_;
};

}  // namespace tiltfeed
