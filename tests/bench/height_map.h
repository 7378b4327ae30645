#pragma once
// A baseline: the plain exact height map of the 3-axis case. Every facet, convex edge and convex vertex
// raises, once, the grid columns under its piece of the CL surface. No slices, no passes, no straight moves,
// no thinning, no check of the mesh: the least that a planner of this kind must do.

#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::bench {
using namespace pathgen;

/// In the frame's t, b, n: z of the ball's centre over (left + i step, front + k step).
struct HeightMap {
  double step = 0.0, left = 0.0, front = 0.0;
  int columns = 0, rows = 0;
  std::vector<double> height;  ///< row by row; -infinity: nothing there
};

/// Requires: a closed, oriented mesh; frame.mode == kFixed; radius, step > 0 (mm).
HeightMap height_map(const Mesh& mesh, const AxisFrame& frame, double radius, double step);

/// The largest difference, mm, to the exact drop of the ball (sim/solid/distance.h) at `samples` random
/// columns.
double largest_error(const HeightMap& map, const Mesh& mesh, const AxisFrame& frame, double radius,
                     int samples);

}  // namespace tiltfeed::bench
