#pragma once
// Points of a pass with their tool axes, and what is asked of these.

#include <vector>

#include "pathgen/free_slices/cl_chains.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

struct ToolAxisOptions {
  FreeAxis wish;
  double tolerance = 0.01;        ///< the job's, mm
  double turn_per_move = 0.05;    ///< of the axis in one move at most, rad
  double longest_move = 0.0;      ///< mm; 0: no limit
  double reference_height = 0.0;  ///< of the CL reference over the tip, mm
};

struct ToolAxisPoint {
  ClPoint point;
  Vec3 axis;
};
/// An unbroken run of cutting moves.
using ToolAxisRun = std::vector<ToolAxisPoint>;

}  // namespace tiltfeed::pathgen
