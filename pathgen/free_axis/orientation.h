#pragma once
// The tool axis along a pass: of all sequences of admissible directions the one that departs least from the
// wished one and turns least. (O1)..(O5) in pathgen/free_axis/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/free_axis/admissible.h"
#include "pathgen/free_slices/cl_chains.h"

namespace tiltfeed {

struct OrientationOptions {
  FreeAxis wish;
  double tolerance = 0.01;        ///< the job's, mm
  double turn_per_move = 0.05;    ///< of the axis in one move at most, rad
  double longest_move = 0.0;      ///< mm; 0: no limit
  double reference_height = 0.0;  ///< of the CL reference over the tip, mm
};

struct OrientedPoint {
  ClPoint point;
  Vec3 axis;
};
/// An unbroken run of cutting moves.
using OrientedRun = std::vector<OrientedPoint>;

/// A stretch that is left out.
struct LeftOut {
  double length = 0.0;  ///< mm
  Uncut why = Uncut::kCutter;
  std::uint32_t facet = kNoFacet;  ///< index into the mesh
};

struct OrientedPass {
  std::vector<OrientedRun> runs;
  std::vector<LeftOut> left_out;
  std::uint64_t stations = 0, tested = 0, breaks = 0;
};

/// Properties: at every point of every run, and densely along its moves (tip straight, axis on the great
/// circle), the tool is clear of the part but for the cutter's share of the tolerance, within the tilt limit,
/// and can be drawn back along its axis; the axis turns by at most wish.max_turn per mm.
OrientedPass orient_pass(const ClChain& chain, const Admissibility& admissible,
                         const OrientationOptions& options);

}  // namespace tiltfeed
