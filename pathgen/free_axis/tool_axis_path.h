#pragma once
// The tool axis along a pass: of all sequences of admissible directions the one that departs least from the
// wished one and turns least. (O1)..(O5) in pathgen/free_axis/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/free_axis/admissible.h"
#include "pathgen/free_axis/tool_axis_run.h"
#include "pathgen/free_slices/cl_chains.h"

namespace tiltfeed::pathgen {

/// A stretch that is left out.
struct LeftOut {
  double length = 0.0;  ///< mm
  RestReason why = RestReason::kCutter;
  std::uint32_t facet = kNoFacet;  ///< index into the mesh
};

struct ToolAxisPass {
  std::vector<ToolAxisRun> runs;
  std::vector<LeftOut> left_out;
  std::uint64_t stations = 0, tested = 0, breaks = 0;
};

/// Properties: at every point of every run, and densely along its moves (tip straight, axis on the great
/// circle), the tool is clear of the part but for the cutter's share of the tolerance, within the tilt limit,
/// and can be drawn back along its axis; the axis turns by at most wish.max_turn per mm.
ToolAxisPass choose_tool_axes(const ClChain& chain, const Admissibility& admissible,
                              const ToolAxisOptions& options);

}  // namespace tiltfeed::pathgen
