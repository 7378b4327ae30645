#pragma once
// Where the tool axis of a part might go: modes and placements, ranked by what the tool reaches. (Q1)..(Q5)
// in pathgen/suggest/README.md.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/stages.h"
#include "pathgen/reach/reach_scene.h"
#include "pathgen/suggest/feature.h"

namespace tiltfeed::pathgen {

/// Over all of the part, mm: so far the tool of a proposal is drawn back, in outward work.
inline constexpr double kProposedClearance = 5.0;

struct SuggestOptions {
  PlanOptions tool;                       ///< its cutter, stock and guards
  const MachineModel* machine = nullptr;  ///< null: nothing limits the tool axis
};

struct Proposal {
  AxisFrame axis;
  std::vector<Vec3> directions;  ///< with kIndexed: those that were counted on; the planner chooses its own
  std::string source;            ///< "fitted", "box", "inertia", "search", "planes", "all directions"
  double rms = 0.0;              ///< of a fitted one: of the corners from the surfaces round it, mm
  Setup setup;
  Vec3 fixture_deg;     ///< of the set-up, about the table's x, then y, then z
  ReachMap reach;       ///< of the places that were asked
  double shaped = 0.0;  ///< the share that is cut where large planes and cylinders hardly count
  double share() const { return reach.share(Reach::kCut); }
};

struct Suggestions {
  std::vector<Proposal> proposals;  ///< the first is the best
  std::vector<Feature> features;    ///< found on the part
  std::size_t tried = 0;            ///< placements
  std::size_t places = 0;           ///< of the surface, asked of each proposal
};

/// The same for any number of threads. Errors: kCancelled; kUnreachable where no placement reaches anything.
Result<Suggestions> suggest(const CheckedMesh& part, const SuggestOptions& options,
                            const Progress& progress = {});

}  // namespace tiltfeed::pathgen
