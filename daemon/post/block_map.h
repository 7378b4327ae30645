#pragma once
// From a motion block back to the part: which planned move it belongs to and which STL facet the tool touches
// there. Written by `tiltfeed plan --map`, one entry for each motion block.

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "daemon/post/posting.h"
#include "kinematics/basics/tool_path.h"

namespace tiltfeed::daemon {

struct BlockOrigin {
  std::uint32_t move = 0;          ///< index into the tool path (and, in order, the CL file's GOTO)
  std::uint32_t facet = kNoFacet;  ///< of the STL, counted from 0
};

/// Of the blocks as they are printed. `paths`: what the words' moves count, of each operation that is not
/// another plane of the one before. Requires: as many.
void write_block_map(const Posting& posting, const std::vector<const ToolPath*>& paths, std::ostream& out);
/// Entry `number`, counted from 1; nothing when the map has fewer. Errors: kIo, kInput when it is no map.
Result<std::optional<BlockOrigin>> read_block_origin(const std::string& path, std::uint64_t number);

}  // namespace tiltfeed::daemon
