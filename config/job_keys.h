#pragma once
// The readers of a job file's sections, in the order in which they need each other. Ranges and rules across
// keys are checked here; problems go to the section's complaint.

#include <string>

#include "config/cutter_keys.h"
#include "config/section.h"
#include "config/tool_library.h"
#include "kinematics/machine/machine.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::config {

struct Job;

/// The names of the axis line's coordinates in a mode, as they stand in the section containment.
struct CoordinateKeys {
  const char *first, *second, *height;
};
constexpr CoordinateKeys coordinate_keys(pathgen::AxisMode mode) {
  if (mode == pathgen::AxisMode::kFixed || mode == pathgen::AxisMode::kFree ||
      mode == pathgen::AxisMode::kIndexed)
    return {"x_mm", "y_mm", "z_mm"};
  if (mode == pathgen::AxisMode::kLine) return {"x_mm", "theta_deg", "rho_mm"};
  return {"theta_deg", "phi_deg", "rho_mm"};
}

/// Whether a kind of pattern has a key of the section pattern.
bool uses_key(pathgen::PatternKind kind, const std::string& key);
/// What a job's section cutter says.
struct CutterChoice {
  pathgen::Cutter cutter;
  std::string id;        ///< of the tool; empty: it has none
  std::string material;  ///< whose cutting data are to be taken; empty: none
  const LibraryTool* tool = nullptr;
  const CuttingData* data = nullptr;
};
/// `tools`: the library that the section names; null: it is not read, and a cutter stands for what it says.
/// The result points into it.
CutterChoice read_cutter(const Section& root, const ToolLibrary* tools);
/// plan.axis, plan.lean and plan.free; Lean::max_turn is 0 where the job leaves it to default_turn().
/// Requires: plan.cutter.
void read_axis(const Section& root, pathgen::PlanOptions& plan);
/// The keys of the section axis in the mode free, and what else of the job does not go with it;
/// FreeAxis::max_turn is 0 where the job leaves it to default_turn(). Requires: plan.cutter.
void read_free_axis(const Section& root, const Section& axis, pathgen::FreeAxis& free,
                    const pathgen::Cutter& cutter);
/// The least of what a cutter of this size is given and what the machine's rotaries can do at the feed, of
/// the tool axis per mm of the ball centre's way. The tip, whose feed it is, goes 1 - radius * turn of a mm
/// in the meantime at the least. The rotary keeps up with it where the tool lies square to its axis; nearer
/// the pole turns about that axis take it longer, and the feed waits for it.
Angle default_turn(const MachineModel& machine, const pathgen::Cutter& cutter, Feed feed);
/// Sets the turns that the job leaves to it.
void set_default_turns(const MachineModel& machine, pathgen::PlanOptions& plan);
/// What the machine's axes can do on rapids: of X Y Z the slowest.
pathgen::RapidRates rapid_rates(const MachineModel& machine);
/// As read_free_axis(), in the mode indexed.
void read_indexed_axis(const Section& root, const Section& axis, pathgen::IndexedAxis& indexed,
                       const pathgen::Cutter& cutter);
pathgen::Pattern read_pattern(const Section& root, const pathgen::PlanOptions& plan);
pathgen::Containment read_containment(const Section& root, pathgen::AxisMode mode);
/// job.only_faces and job.beyond_faces. Requires: plan.pattern, plan.cutter.
void read_only_faces(const Section& root, Job& job);
/// Feeds and speed: what the job says, else the tool's in the material.
void read_feeds(const Section& root, const CutterChoice& choice, Job& job);
/// Tolerance, what is left on the part, points, guards, links. Requires: plan.cutter.
void read_path(const Section& root, pathgen::PlanOptions& plan);
/// points.axis_tolerance_deg. Requires: plan.cutter, plan.axis.
Angle read_axis_tolerance(const Section& root, const pathgen::PlanOptions& plan);
/// points.calm_deg. Requires: as it, and plan.shank, plan.holder.
Angle read_calm(const Section& root, const pathgen::PlanOptions& plan);
/// Also plan.up and plan.tilt_max. Requires: plan.cutter.
Setup read_setup(const Section& root, pathgen::PlanOptions& plan);

}  // namespace tiltfeed::config
