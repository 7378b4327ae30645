#pragma once
// Directions spread evenly over the sphere: the corners of an icosahedron whose facets are cut into four
// again and again. Those of a coarser grid come first.

#include <cstdint>
#include <span>
#include <vector>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::pathgen {

class DirectionGrid {
 public:
  /// 12, 42, 162, 642, 2562, 10242 directions for level 0 to 5; neighbours are 63, 32, 16, 8, 4, 2 degrees
  /// apart.
  explicit DirectionGrid(int level);

  const std::vector<Vec3>& directions() const { return directions_; }
  /// How many directions a level has; they are the first of all.
  static std::uint32_t count(int level) { return 10u * (1u << (2 * level)) + 2u; }
  int level() const { return level_; }
  /// Those of a level, up to this one, in the order of z.
  const std::vector<std::uint32_t>& rising(int level) const {
    return rising_[static_cast<std::size_t>(level)];
  }
  /// No direction is further from the nearest of a level's than this, rad.
  static double coverage(int level);

 private:
  int level_;
  std::vector<Vec3> directions_;
  std::vector<std::vector<std::uint32_t>> rising_;
};

/// Of each direction of a level the others near it.
class DirectionNeighbours {
 public:
  struct Neighbour {
    std::uint32_t direction = 0;
    double square = 0.0;  ///< of the chord between the two
  };
  /// Within `chord` of each other.
  DirectionNeighbours(const DirectionGrid& grid, int level, double chord);

  /// The nearest first; the first is the direction itself. Requires: direction < count().
  std::span<const Neighbour> of(std::uint32_t direction) const { return near_[direction]; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(near_.size()); }
  double chord() const { return chord_; }

 private:
  double chord_;
  std::vector<std::vector<Neighbour>> near_;
};

}  // namespace tiltfeed::pathgen
