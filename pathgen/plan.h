#pragma once
// The stages in order: mesh -> CL surface -> flat space -> slices -> upper envelope -> passes -> tool path.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kinematics/result.h"
#include "kinematics/tool_path.h"
#include "pathgen/cutter.h"
#include "pathgen/deformation.h"
#include "pathgen/linking.h"
#include "pathgen/mesh.h"
#include "pathgen/slices.h"

namespace tiltfeed {

struct PlanOptions {
  std::string name;  ///< of the part
  Cutter cutter;
  AxisFrame axis;
  Along along = Along::kX;
  Direction direction = Direction::kZigzag;
  double side_step = 0.0;   ///< between neighbouring passes in flat space, mm
  double tolerance = 0.01;  ///< largest gouge, and largest gap where contact is meant, part space, mm
  double allowance = 0.0;   ///< stock left on the part, mm
  double clearance = 0.0;   ///< of the clearance surface over the highest CL point, mm
  double approach = 0.0;    ///< the last part of an approach, travelled at plunge feed, mm
  Feed cut_feed, plunge_feed;
  Vec3 up{0, 0, 1};  ///< the table's axis in part directions, unit
  Angle tilt_max =
      Angle::from_degrees(180.0);  ///< largest angle of the tool axis to `up`; the rest is left out
};

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
