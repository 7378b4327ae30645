#pragma once
// A plan with a predefined axis of only a part of what the tool can reach.

#include <functional>

#include "pathgen/envelope/envelope.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed {

/// A part of what the tool can reach.
struct WantedPart {
  /// Shall the tool cut there? Asked along straight moves, too, where nothing but `centre` is exact.
  std::function<bool(const EnvelopePoint&)> place;
  /// May the tool cut straight from one point to the next of a pass? Empty: always. A pass is broken where
  /// not.
  std::function<bool(const EnvelopePoint&, const EnvelopePoint&)> straight{};
  double spacing = 0.0;  ///< a pass is asked at places at most this far apart, mm
  double overlap = 0.0;  ///< it is cut this much beyond along the pass, mm
};

/// As plan(), with every pass cut down to what is wanted. What is refused elsewhere is no warning.
/// Errors: as plan(); kUnreachable when nothing is left.
Result<Plan> plan_where(const CheckedMesh& part, const PlanOptions& options, const WantedPart& wanted,
                        const Progress& progress);

}  // namespace tiltfeed
