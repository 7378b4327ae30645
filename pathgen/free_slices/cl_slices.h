#pragma once
// The whole CL surface of a ball, cavities and bores included, cut by stacks of parallel planes into passes.
// (N7), (N8) in pathgen/free_slices/README.md.

#include <cstdint>
#include <functional>
#include <vector>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/free_slices/cl_chains.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// A pass: places of the ball's centre, no nearer to the part than its radius but for `tolerance`, no further
/// from the CL surface than that.
struct ClSlice {
  std::uint32_t stack = 0;  ///< which of the normals
  double height = 0.0;      ///< of the plane along it, mm
  std::uint32_t plane = 0;  ///< counts the planes of the stack, from below
  ClChain chain;
};

/// The slices of the part by the stacks of options.free, where the containment allows, by stack and height;
/// the same for any number of threads. Each place belongs to the stack whose planes cut it most squarely.
/// With measure surface or scallop further planes lie between where the surface leans towards a plane.
/// Chords, dropped points and gaps take their shares of the budget. Empty when `go_on` returned false: it is
/// asked now and then, on one thread, with 0..1.
std::vector<ClSlice> slice_cl_surface(const CheckedMesh& part, const FacetBvh& tree,
                                      const PlanOptions& options, const ToleranceBudget& budget,
                                      const std::function<bool(double)>& go_on);

}  // namespace tiltfeed::pathgen
