#pragma once
// Finds the patches that a straight line of the flat space can meet, and where along it. (S1), (S6) in
// pathgen/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/cells.h"
#include "pathgen/deformation.h"
#include "pathgen/flat_bins.h"

namespace tiltfeed {

/// Patch `patch` can be the highest only for run coordinates in [from, to].
struct Candidate {
  double from = 0.0, to = 0.0;
  PatchId patch = 0;
  float top = std::numeric_limits<float>::infinity();  ///< as Cell::top
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

  /// A patch may be the highest in `box` only.
  struct Nearby {
    FlatBox box;
    PatchId patch = 0;
    float top = std::numeric_limits<float>::infinity();  ///< as Cell::top
  };
  /// The patches that may be the highest somewhere in `box`, the one that may be highest of all first; some
  /// more than once.
  void near(const FlatBox& box, Scratch& scratch, std::vector<Nearby>& nearby) const;
  /// As along(), for a line in the box that `nearby` was found for; intervals are those of the boxes.
  static void along(const FlatLine& line, const std::vector<Nearby>& nearby, Scratch& scratch,
                    std::vector<Candidate>& candidates);
  /// About the distance of neighbouring cells, mm.
  double spacing() const { return bins_.finest(); }

  /// Calls visit(patch) for each cell whose box holds (x, y), until it returns true; returns that.
  template <class Visit>
  bool any_at(double x, double y, Visit visit) const {
    return bins_.any_at(x, y, [&](std::uint32_t cell) {
      return holds(cells_.cells[cell], x, y) && visit(cells_.cells[cell].patch);
    });
  }
  /// About how many cells lines in the direction (dx, dy), `step` apart, cut in all.
  double crossings(double dx, double dy, double step) const;

  const FlatBounds& bounds() const { return bounds_; }
  const std::vector<PatchId>& covering() const { return cells_.near; }

 private:
  bool holds(const Cell& cell, double x, double y) const;
  bool has_siblings(std::uint32_t cell) const;
  void ask(Scratch& scratch) const;
  template <class Visit>
  void each_turn(const FlatBox& box, const FlatBox& swept, Visit visit) const;
  void add_cell(const Cell& cell, const FlatLine& line, const FlatBox& swept,
                std::vector<Candidate>& candidates) const;

  Cells cells_;
  /// Where a coordinate wraps and is covered past its seam, else 0.
  double period_x_ = 0.0, period_y_ = 0.0;
  FlatBounds bounds_;
  FlatBins bins_;
};

}  // namespace tiltfeed
