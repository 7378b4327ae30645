#pragma once
// Runs with free axes to one tool path: out along the axis to a sphere round everything, over it, and in
// again; or a short way close by. (J1)..(J4) of the section on free links in pathgen/free_axis/README.md.

#include <cstdint>
#include <functional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/free_axis/admissible.h"
#include "pathgen/free_axis/tool_axis_path.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

struct FreeLinked {
  std::vector<Move> moves;
  std::uint64_t retracts = 0;      ///< to the sphere, the last one included
  std::uint64_t joins = 0;         ///< over the surface, in contact
  std::uint64_t short_links = 0;   ///< close to the part
  std::uint64_t skipped_runs = 0;  ///< to which no way keeps the tilt limit
  std::uint64_t tested = 0;        ///< poses held against the part
};

/// The stock that rapids keep off. Without functions: none is known.
struct LinkStock {
  /// From `high` (mm over the CL reference along the unit axis) down to which the tool comes clear, at least
  /// `low`.
  std::function<double(Point<Part> reference, Vec3 axis, double high, double low)> clear_down_to{};
  /// Does a tool that has cut at `down` come too near when it is drawn out to `up`, and goes `over` there?
  std::function<bool(const Pose& down, const Pose& up, const Pose& over)> short_way_in{};
};

/// `how`: the runs were oriented. Each run is travelled once, backwards only where `reversible`; in the
/// quicker of two orders, (J5). Properties: on links the whole tool is clear of the part, and outside the
/// sphere, `options.links.clearance` from everything; every pose keeps the tilt limit. `source`:
/// Mesh::source. When the user stops it, the moves are not all there.
FreeLinked link_runs(const std::vector<ToolAxisRun>& runs, bool reversible, const Admissibility& admissible,
                     const ToolAxisOptions& how, const PlanOptions& options,
                     const std::vector<std::uint32_t>& source, const LinkStock& stock = {},
                     const ReportShare& report = {});

}  // namespace tiltfeed::pathgen
