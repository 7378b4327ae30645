#pragma once
// The job file: part, cutter, axis field, pattern, containment, guards, links, feeds, set-up. YAML lives and
// dies in config/*.cpp. Every key: config/jobs/example.yaml.

#include <string>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed::config {

struct Job {
  std::string path;          ///< the file it came from
  std::string stl_path;      ///< resolved against the job file's folder
  double stl_unit_mm = 1.0;  ///< length of the STL's unit
  pathgen::PlanOptions plan;
  Angle axis_tolerance;      ///< by which the axis may lean near the rotary's pole; 0: not at all
  Setup setup;               ///< tool_length = plan.cutter.length
  double spindle_rpm = 0.0;  ///< 0: no spindle words
  ProgramData program;
  MachineProfile machine;
};

/// Typed directions are rounded, to five decimals as a rule: t and n may miss the right angle by this much
/// (rad) and are then made exactly perpendicular, t kept.
inline constexpr double kPerpendicularTolerance = 1e-5;

/// Reads the job and the machine profile that it names.
/// Properties: every value is finite and in range; t, n are unit and perpendicular; `fixture` is a rotation,
/// exact for multiples of 90 degrees; 0 < approach <= clearance; height of the cutter's rounded end <=
/// cutting_end() <= shank_length <= length; the boundary is a polygon without crossings; what the kind of
/// pattern does not use has its default, and side_step is 0 where a scallop alone sets the step.
/// Errors: kInput as file:line:column, what was expected, the nearest known key; kIo.
Result<Job> load_job(const std::string& path);
/// A job whose files lie elsewhere than its text says; empty: as the job says.
struct JobFiles {
  std::string stl, machine;
};
/// Errors: as load_job.
Result<Job> load_job_with(const std::string& path, const JobFiles& files);
/// The same from text; `path` names it in messages and its folder is where relative paths start.
Result<Job> parse_job(const std::string& text, const std::string& path);
/// The resolved job and its machine, one `key: value` a line.
std::string describe(const Job& job);

}  // namespace tiltfeed::config
