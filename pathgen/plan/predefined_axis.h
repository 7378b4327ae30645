#pragma once
// The planner of a predefined axis: everywhere, or only for a part of what the tool can reach.

#include <functional>

#include "pathgen/envelope/envelope.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"

namespace tiltfeed::pathgen {

/// A part of what the tool can reach.
struct WantedPart {
  /// True where the tool must cut. Also called on interpolated points, of which only `centre` is exact.
  /// Empty: everywhere. From several threads.
  std::function<bool(const EnvelopePoint&)> place;
  /// May the tool cut straight from one point to the next of a pass? Empty: always. A pass is broken where
  /// not.
  std::function<bool(const EnvelopePoint&, const EnvelopePoint&)> straight{};
  /// The z' down to which a rapid may come over a place, from a z' and at least a z'. Empty: any.
  std::function<double(const Deformation& field, Point<Flat> place, double from, double to)> free_from{};
  bool whole = false;    ///< what is left out has nothing to cut: all of the part counts in the report
  double bridge = 0.0;   ///< a pass goes on over what is not wanted, if that is shorter, mm
  double spacing = 0.0;  ///< a pass is asked at places at most this far apart, mm
  double overlap = 0.0;  ///< it is cut this much beyond along the pass, mm
};

/// As plan(), of an axis mode that is neither free nor indexed; with every pass cut down to what is wanted,
/// if that is not null. Points rejected outside of it raise no warning. Errors: as plan(); kUnreachable when
/// nothing is left.
Result<Plan> plan_where(const CheckedMesh& part, const PlanOptions& options, const WantedPart* wanted,
                        const Progress& progress);

/// A plan with everything but moves and report.
Plan plan_without_moves(const PlanOptions& options);
/// Counts points and passes, and adds up lengths.
void measure(const std::vector<Move>& moves, PlanReport& report);

}  // namespace tiltfeed::pathgen
