#pragma once
// The chosen directions of a pass evened out, as far as they stay admissible, and no turn over the limit.
// (O4) in pathgen/free_axis/README.md.

#include <vector>

#include "pathgen/free_axis/stations.h"

namespace tiltfeed::pathgen {

/// The tool axis at a place of the pass.
struct AxisAt {
  double way = 0.0;  ///< mm
  ClPoint point;
  Vec3 wished, axis;     ///< unit
  bool is_wish = false;  ///< the wish is the only candidate
};
/// Stations that follow each other without a break.
using AxisStretch = std::vector<AxisAt>;

struct EveningLimits {
  double scale = 0.0;     ///< over which a turn costs as much as a departure, mm
  double max_turn = 0.0;  ///< rad/mm
};

/// Towards the directions of least departure and turn, where they are admissible.
void even_out(AxisStretch& stretch, const EveningLimits& limits, const Admissibility& admissible,
              DirectionQuery& query);

/// Turns over the limit spread over the stations before and after, where all of them admit it; elsewhere the
/// stretch is cut in two. Property: no turn within one of the stretches is over the limit.
std::vector<AxisStretch> spread_turns(AxisStretch stretch, const EveningLimits& limits,
                                      const Admissibility& admissible, DirectionQuery& query);

}  // namespace tiltfeed::pathgen
