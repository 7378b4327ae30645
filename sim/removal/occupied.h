#pragma once
// Where the tool may be without coming near any stock.

#include <array>
#include <cstdint>
#include <vector>

#include "sim/removal/stock.h"

namespace tiltfeed::sim {

/// Where stock is near at the start, in coarse cubes.
class Occupied {
 public:
  /// Cubes within `reach` of stock count.
  Occupied(const Stock& stock, double reach);
  /// How far round p nothing is near, mm, or below 0: stock is.
  double clear(Point<Part> p) const;

 private:
  std::array<int, 3> index(Vec3 p) const;
  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * size_[1] + y) * size_[0] + x;
  }
  void measure();
  Vec3 origin_, end_;
  double cube_;
  std::array<int, 3> size_{};
  int by_;                            ///< cubes up to this far from stock are near
  std::vector<std::uint16_t> cubes_;  ///< how many it is to the nearest one with stock, in any direction
};

}  // namespace tiltfeed::sim
