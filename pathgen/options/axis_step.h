#pragma once
// How far the tool axis may turn in one move.

#include <algorithm>
#include <cmath>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// (E5), (O5) So far (rad) that the ball's centre leaves its straight line, R turn^2 / 8, and the shank's end
/// its ruled surface, (shank length) turn^2 / 8, by no more than their shares; and no further than
/// options.max_angle_step.
inline double largest_axis_step(const PlanOptions& options) {
  const ToleranceBudget budget(options.tolerance);
  const double shank = std::max(options.cutter.shank_length, options.cutter.radius());
  const double step = std::sqrt(
                   8.0 * std::min(budget.shank_turn() / shank, budget.turn() / options.cutter.radius())),
               asked = options.max_angle_step.radians();
  return asked > 0.0 ? std::min(step, asked) : step;
}

}  // namespace tiltfeed::pathgen
