#pragma once
// The nearest of a set of points from which points are taken away: a balanced tree of halves.

#include <cstdint>
#include <optional>
#include <vector>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::pathgen {

class NearestEnds {
 public:
  explicit NearestEnds(std::vector<Point<Part>> points);

  /// Index of the nearest point that is left, the lowest index of equals; nothing when none is left.
  std::optional<std::uint32_t> nearest(Point<Part> from) const;
  /// Requires: point `index` has not been removed.
  void remove(std::uint32_t index);

 private:
  struct Best {
    double squared = 0.0;
    std::optional<std::uint32_t> index;
  };
  void build(std::size_t from, std::size_t to);
  void search(std::size_t from, std::size_t to, Point<Part> place, Best& best) const;

  std::vector<Point<Part>> points_;
  std::vector<std::uint32_t> order_;     ///< of each range, the middle one is its node
  std::vector<std::uint32_t> place_;     ///< of each point in order_
  std::vector<std::uint32_t> left_;      ///< by place: how many points of the node's range are left
  std::vector<std::uint8_t> dimension_;  ///< by place: which coordinate the node halves
  std::vector<std::uint8_t> gone_;       ///< by place
};

}  // namespace tiltfeed::pathgen
