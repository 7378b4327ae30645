#pragma once
// Was every block of the program executed once, in order, unaltered?

#include <cstdint>
#include <string>
#include <vector>

#include "sim/gcode/gcode_reader.h"
#include "sim/motion/trace.h"

namespace tiltfeed::sim {

struct BlockComparison {
  std::uint64_t blocks = 0;    ///< of the program
  std::uint64_t executed = 0;  ///< rows of the trace, less a closing `G4 P0` that the host added as a barrier
  std::uint64_t missing = 0;   ///< blocks of the program without a row
  std::uint64_t repeated = 0;  ///< rows beyond the program's blocks: executed twice, or never sent
  std::uint64_t altered = 0;   ///< rows in a block's place with another code, word or feed
  std::string first_difference;  ///< empty when there is none
  bool good() const { return missing + repeated + altered == 0; }
};

/// Compares by content, block by block, code, axis words and feed; after a difference it looks for the
/// nearest place where both agree again. Line numbers are not compared: a sender may renumber.
BlockComparison compare_blocks(const std::vector<Block>& program, const std::vector<TraceRow>& trace);

}  // namespace tiltfeed::sim
