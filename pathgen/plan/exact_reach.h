#pragma once
// What becomes of each facet when a job is planned: the plan's own report, facet by facet. (U5) in
// pathgen/plan/README.md.

#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/stages.h"
#include "pathgen/reach/reach_scene.h"

namespace tiltfeed::pathgen {

/// Plans `options` and says what its report says of each facet: kCut where less than half of it stays uncut,
/// kAway where no piece of it faces the tool. Areas are by the report's shares of facets, not by these words.
/// Besides, what the plan does not know: of what it cuts, that `question.machine` does not go there (its tilt
/// and up are those of `options`). `facets`: of scene.facets(). With AxisMode::kIndexed the plan chooses the
/// directions, and rays say what they reach.
/// Errors: as plan(); kCancelled when `progress` says so.
Result<ReachMap> exact_reach(const CheckedMesh& part, const PlanOptions& options, const ReachScene& scene,
                             std::span<const ReachPlace> facets, const ReachQuestion& question,
                             const Progress& progress = {});

}  // namespace tiltfeed::pathgen
