#pragma once
// Which cells each of many parallel lines may meet, found cell by cell: each cell is looked at once, not once
// for each line that passes it. (S7) in pathgen/README.md.

#include <cstdint>
#include <span>
#include <vector>

#include "pathgen/flat_index.h"

namespace tiltfeed {

class RowCells {
 public:
  RowCells() = default;
  /// Requires: the lines have one direction, and their distance to the left of the origin does not fall from
  /// line to line.
  RowCells(const FlatIndex& index, std::span<const FlatLine> lines);

  /// By rising number, each once: all cells that line `i` meets, and few others.
  std::span<const std::uint32_t> of(std::size_t i) const {
    return {cells_.data() + first_[i], cells_.data() + first_[i + 1]};
  }

 private:
  std::vector<std::uint32_t> first_;  ///< by line, in cells_
  std::vector<std::uint32_t> cells_;
};

}  // namespace tiltfeed
