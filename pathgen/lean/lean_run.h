#pragma once
// Stretches of a pass with their leans, and the moves between two places of them. (Y5) in
// pathgen/lean/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/lean/lean_stations.h"
#include "pathgen/lean/lean_tool.h"

namespace tiltfeed::pathgen {

struct LeanedPlace {
  LeanStation station;
  LeanAngle lean;
  Vec3 axis() const { return station.axis(lean); }
};
/// Places that follow each other without a break.
using LeanedRun = std::vector<LeanedPlace>;

/// The ends of the moves on which the tool goes from `a` to `b`, the last one `b` itself: the lean changes
/// evenly, and no move turns the axis by more than LeanTool::largest_turn().
LeanedRun moves_between(const LeanTool& tool, const PassFrames& frames, const LeanedPlace& a,
                        const LeanedPlace& b);

/// Is the tool clear on all of them?
bool clear_between(const LeanTool& tool, const PassFrames& frames, const LeanedPlace& a, const LeanedPlace& b,
                   std::uint32_t& hint);

/// The run with the same lean all the way from its end (`forwards`) or its start to as near to `run` (mm
/// along the pass) as the tool is clear.
void extend(const LeanTool& tool, const PassFrames& frames, double run, bool forwards, LeanedRun& places,
            std::uint32_t& hint);

/// Without places, other than points of the pass, whose lean the neighbours' give within a small angle, where
/// the tool stays clear.
LeanedRun thinned_run(const LeanTool& tool, const PassFrames& frames, const LeanedRun& run,
                      std::uint32_t& hint);

/// The points of the tool's moves along it.
Pass pass_of(const LeanTool& tool, const PassFrames& frames, const LeanedRun& run);

}  // namespace tiltfeed::pathgen
