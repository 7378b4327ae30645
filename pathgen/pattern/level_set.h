#pragma once
// One level's contours as loops of crossings with the grid lines, and the connected regions on both sides of
// them. (Z1), (Z2) in pathgen/pattern/README.md.

#include <array>
#include <vector>

#include "pathgen/pattern/level_grid.h"

namespace tiltfeed::pathgen {

/// A crossing of the level on a grid line, between two places of it.
struct Crossing {
  Place outside, inside;  ///< at most as high as the level; higher
};

/// Somewhere in a region: on a node, or on a grid edge at a run of its line; neither: not known.
struct Witness {
  int node = -1, edge = -1;
  double run = 0.0;
};

/// A closed contour; what is higher lies on its left. Where a coordinate wraps, places may run past the seam.
struct Loop {
  std::vector<Crossing> crossings;
  int inside = -1, outside = -1;  ///< regions beside it
  Witness in_inside, in_outside;
};

class LevelSet {
 public:
  /// Crossings are found within `fineness` (mm). Features that no grid line meets are missed.
  LevelSet(const LevelGrid& grid, double level, Heights& heights, double fineness);

  const std::vector<Loop>& loops() const { return loops_; }
  /// Region of a witness found on any level's set of the same grid; -1 where it is not known.
  int region_at(const Witness& witness) const;
  /// Does the region reach to where there is no surface, beyond the grid's borders?
  bool is_sea(int region) const;

 private:
  /// A side of a cell from its lower to its upper end: pieces of one state with crossings between them.
  struct Side {
    std::vector<int> crossings, pieces;
  };
  struct Cell {
    double x0, y0, x1, y1;
    std::array<Side, 4> sides;  ///< bottom, right, top, left
  };
  /// The border of a cell, counter-clockwise: `after[i]` is the piece after crossing i.
  struct Ring {
    std::vector<int> crossings, after, side;
  };
  /// Crossings of a grid edge: from `first` on; thin pieces between them: from `thin` on.
  struct ActiveEdge {
    int edge, first, count, thin;
  };

  int find(int piece) const;
  void unite(int a, int b);
  int new_piece(bool inside);
  bool higher(double z) const { return z > level_; }
  void cross_line(const std::vector<HeightSample>& samples, const FlatLine& line, double step, int cells,
                  int first_edge, const std::vector<int>& nodes);
  /// Crossings on one edge of a line, its samples from `next` on; moves `next` on.
  std::vector<Crossing> cross_edge(const std::vector<HeightSample>& samples, const FlatLine& line,
                                   std::size_t& next, double from, double to, bool in_from, bool in_to);
  Side side_of(int edge, int low, int high) const;
  void cross_cells();
  Ring ring_of(const Cell& cell) const;
  void resolve(const Cell& cell, int depth);
  void link(const Ring& ring, std::size_t exit, std::size_t entry);
  void link_all(const Ring& ring, bool inside_connected);
  bool connected(const Cell& cell, const Ring& ring, bool inside);
  Place place_of(const Cell& cell, const Ring& ring, std::size_t arc) const;
  void split(const Cell& cell, int depth);
  Side inner_side(Place from, Place to, int low, int high);
  void close_loops();
  void label_regions();

  const LevelGrid& grid_;
  double level_, fineness_;
  Heights& heights_;
  int row_edges_ = 0;
  std::vector<Crossing> crossings_;
  std::vector<std::array<int, 2>> beside_;  ///< by crossing: its inside and outside piece, once linked
  std::vector<int> next_;                   ///< by crossing: the next of its loop
  mutable std::vector<int> parent_;         ///< by piece, nodes first: union-find
  std::vector<bool> inside_;                ///< by piece
  std::vector<ActiveEdge> active_;          ///< by rising edge
  std::vector<int> active_of_;              ///< by edge: its index in active_, -1: none
  std::vector<Loop> loops_;
};

}  // namespace tiltfeed::pathgen
