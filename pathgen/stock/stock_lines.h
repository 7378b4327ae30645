#pragma once
// Stock as pieces of material on parallel lines, in rows of tiles that threads take one by one.
// (LE2), (LE3) in pathgen/stock/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/stock/round_solid.h"

namespace tiltfeed::pathgen {

class StockLines {
 public:
  /// What is inside of a closed mesh, facets turned outwards. Lines along x, y or z (0, 1, 2), through the
  /// middles of squares `apart` (mm) wide from the mesh's least corner.
  StockLines(const Mesh& blank, int along, double apart);

  int along() const { return along_; }
  double apart() const { return apart_; }
  std::size_t rows() const { return rows_.size(); }
  /// May it meet lines of that row?
  bool in_row(std::size_t row, const PlacedSolid& solid) const {
    return solid.low().v <= row_low(row + 1) && solid.high().v >= row_low(row);
  }

  /// Takes the solid away from the lines of a row. Different rows may be cut at the same time.
  void cut(std::size_t row, const PlacedSolid& solid);
  /// How deep what stands on the lines of a row is in the solid, mm; 0: nothing is. (LE4)
  double deepest(std::size_t row, const PlacedSolid& solid) const;
  /// Is a place on a line (the nearest one) in material?
  bool holds(LinePlace place) const;

  /// Is there material about a place, by the four lines round it, half of their distance up or down? A place
  /// beyond the stock is taken for the nearest one at its border.
  bool stands_about(LinePlace place) const;

  /// mm^3, by the lines.
  double volume() const;

 private:
  static constexpr int kTile = 8;  ///< lines of a tile, along u and v
  struct Line {
    LineSpan first{1.0, 0.0};     ///< the lowest piece; low > high: none
    std::vector<LineSpan> above;  ///< ascending
    bool empty() const { return first.low >= first.high; }
    double top() const { return above.empty() ? first.high : above.back().high; }
  };
  struct Tile {
    double low = 0.0, high = 0.0;  ///< no material is beyond; low > high: none
    int stale = 0;                 ///< cuts since they were found
  };
  struct Row {
    std::vector<Line> lines;  ///< u, then v within a tile's row
    std::vector<Tile> tiles;
  };
  struct Window {
    int u0, u1, v0, v1;  ///< lines, both included; v within the row
  };
  void fill(const Mesh& blank);
  Window window(std::size_t row, const PlacedSolid& solid) const;
  template <class Lines, class Take>
  static void each_line(Lines& of, std::size_t row, const PlacedSolid& solid, const Take& take);
  static bool remove(Line& line, LineSpan gone);
  void bound(std::size_t row, int tile);
  double row_low(std::size_t row) const { return v_ + static_cast<double>(row) * kTile * apart_; }
  Line& line(std::size_t row, int u, int v) {
    return rows_[row].lines[static_cast<std::size_t>(v * nu_ + u)];
  }
  const Line& line(std::size_t row, int u, int v) const {
    return rows_[row].lines[static_cast<std::size_t>(v * nu_ + u)];
  }

  int along_;
  double apart_, u_ = 0.0, v_ = 0.0;     ///< mm; of the first square's least corner
  double lowest_ = 0.0, highest_ = 0.0;  ///< of the mesh along the lines, mm
  int nu_ = 0, nv_ = 0;
  std::vector<Row> rows_;
};

}  // namespace tiltfeed::pathgen
