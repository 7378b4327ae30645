#pragma once
// The stages in order: mesh -> CL surface -> flat space -> slices -> upper envelope -> passes -> tool path.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kinematics/result.h"
#include "kinematics/tool_path.h"
#include "pathgen/mesh.h"
#include "pathgen/plan_options.h"

namespace tiltfeed {

/// Called on one thread with the stage's name and 0..1; return false to cancel.
using Progress = std::function<bool(const char* stage, double fraction)>;

struct StageTime {
  std::string stage;
  double seconds = 0.0;
};

struct PlanReport {
  std::uint64_t facets = 0;
  std::uint64_t passes = 0;                     ///< unbroken runs of cutting moves
  std::uint64_t slice_points = 0;               ///< envelope points before thinning
  std::uint64_t points = 0;                     ///< cutting moves of the path
  std::uint64_t retracts = 0;                   ///< to the clearance surface, the last one included
  std::uint64_t joins = 0;                      ///< passes begun from the one before, on the surface
  double cut_length = 0.0, rapid_length = 0.0;  ///< of the tip, mm
  std::vector<std::string> warnings;
  std::vector<StageTime> times;
};

struct Plan {
  ToolPath path;
  PlanReport report;
};

/// Properties: no gouge over `tolerance` by ball or shank, contact within `tolerance`, on every point of
/// every cutting move; rapids clear the part by at least `clearance` - tolerance once retracted.
/// Errors: kMesh, kLimit, kUnreachable, kGouge: what, which facets, what to change.
Result<Plan> plan(const CheckedMesh& part, const PlanOptions& options, const Progress& progress);

}  // namespace tiltfeed
