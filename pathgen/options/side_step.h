#pragma once
// How far apart neighbouring passes may be on the part.

#include <algorithm>
#include <cmath>

#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// Passes so far apart on a plane leave ridges of `height` between them for a rounding of the tool, mm. (R2)
inline double step_of_scallop(double rounding, double height) {
  const double h = std::min(height, rounding);
  return 2.0 * std::sqrt(2.0 * rounding * h - h * h);
}

/// The side step that a job asks for, mm: its own, or that of its scallop; the smaller where it gives both. 0
/// where it gives none.
inline double asked_step(const PlanOptions& options) {
  const Pattern& pattern = options.pattern;
  if (pattern.measure != StepMeasure::kScallop) return pattern.side_step;
  const double step = step_of_scallop(options.cutter.nose_radius(), pattern.scallop);
  return pattern.side_step > 0.0 ? std::min(step, pattern.side_step) : step;
}

}  // namespace tiltfeed::pathgen
