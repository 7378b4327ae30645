#pragma once
// Where a predefined axis gives way: the passes lean, and what links them comes to know of it.

#include <memory>
#include <optional>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/lean/leaned_passes.h"
#include "pathgen/linking/link_options.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"
#include "pathgen/pattern/pass_depth.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/plan/rest_material.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

class LeanStage {
 public:
  /// All but `cutter` and `found` must outlive it. `field`: that of the passes, which knows nothing of what
  /// may lean; `cutter`: of the cutting part and the fixtures that it meets, on the same axis; `found`: the
  /// passes before anything beyond the axis feature cut them.
  LeanStage(const CheckedMesh& part, const PlanOptions& options, const EnvelopeOptions& envelope,
            const ClField& field, double clearance_z);

  /// Leans the passes, and tells the report. Errors: kUnreachable when nothing is left; kCancelled.
  Result<void> run(const ClField& cutter, const Passes& found, std::vector<std::vector<Pass>>& passes,
                   PlanReport& report, const ReportShare& share);

  /// For upright tools on the way from pass to pass: with all that may lean as it stands.
  const ClField& linked() const { return guarded_ ? *guarded_ : field_; }
  /// Does linked() know shank and holder at this place?
  bool knows(Point<Flat> place) const { return !depth_ || depth_->knows(place); }
  const LeanedWays& ways() const { return ways_; }
  /// What keeps an upright tool off.
  std::optional<HeldStand> held(const EnvelopePoint& stand) const;

 private:
  Result<void> tell(const LeanFigures& figures, PlanReport& report) const;

  const CheckedMesh& part_;
  const PlanOptions& options_;
  const ClField& field_;
  std::unique_ptr<const ClField> fixtures_, guarded_;
  std::optional<PassDepth> depth_;
  LeanTool tool_;
  Envelope envelope_;  ///< of the field of the passes
  LeanedWays ways_;
};

}  // namespace tiltfeed::pathgen
