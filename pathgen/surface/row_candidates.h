#pragma once
// What may be the highest along each of many parallel lines, found hull by hull: each hull is looked at once,
// not once for each line that passes it. (S7) in pathgen/surface/README.md.

#include <cstdint>
#include <span>
#include <vector>

#include "pathgen/surface/flat_index.h"

namespace tiltfeed::pathgen {

class RowCandidates {
 public:
  RowCandidates() = default;
  /// Requires: the lines have one direction, and their distance to the left of the origin does not fall from
  /// line to line.
  RowCandidates(const FlatIndex& index, std::span<const FlatLine> lines);

  /// Where line `i` meets a hull, by rising patch; those of one patch may overlap.
  void of(std::size_t i, std::vector<Candidate>& met) const;

 private:
  /// What neighbouring hulls meet.
  struct Block {
    std::vector<Candidate> met;        ///< by line, then by hull
    std::vector<std::uint32_t> first;  ///< of each line, in `met`
  };
  std::vector<Block> blocks_;
};

}  // namespace tiltfeed::pathgen
