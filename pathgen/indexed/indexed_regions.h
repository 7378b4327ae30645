#pragma once
// Which of the chosen directions cuts which cell of the surface.

#include <array>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "pathgen/indexed/indexed_cells.h"

namespace tiltfeed::pathgen {

class IndexedRegions {
 public:
  /// A cell belongs to the direction that reaches it and faces it best. Within `overlap` (mm) of the border
  /// it is cut from both sides, where both reach it. What none reaches in its middle is left to all: some of
  /// it may be in reach. `cells` must outlive the object.
  /// Requires: at most kMostDirections, `sets` of reach_sets(cells, directions), cells of `size` (mm).
  IndexedRegions(const std::vector<SurfaceCell>& cells, double size, const std::vector<Vec3>& directions,
                 const std::vector<std::vector<std::uint8_t>>& sets, double overlap);

  /// Shall direction d cut where it touches this facet of the mesh at p, a place of it?
  bool wants(std::size_t d, Point<Part> p, std::uint32_t facet) const;
  /// Of the cells that belong to it, mm^2.
  double area(std::size_t d) const { return area_[d]; }
  /// Passes asked this closely miss no cell, mm.
  double spacing() const { return size_; }

 private:
  using Key = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& k) const;
  };
  /// The box of `edge` (mm) that p is in.
  static Key key(Point<Part> p, double edge);
  /// Calls visit(key) for the box of p and all beside it.
  template <class Visit>
  static void each_near(Point<Part> p, double edge, const Visit& visit);

  const std::vector<SurfaceCell>& cells_;
  double size_;
  std::unordered_map<Key, std::vector<std::uint32_t>, Hash> at_;  ///< cells by box of size_
  std::vector<std::uint32_t> wanted_;                             ///< a bit for each direction, of each cell
  std::vector<double> area_;
};

}  // namespace tiltfeed::pathgen
