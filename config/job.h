#pragma once
// The job file: part, cutter, axis field, pattern, containment, guards, links, feeds, set-up. YAML lives and
// dies in config/*.cpp. Every key: config/jobs/example.yaml.

#include <optional>
#include <string>
#include <vector>

#include "config/blank.h"
#include "config/machine_profile.h"
#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed::config {

/// Which of a job's operations it is.
struct OperationName {
  std::string name = {};              ///< empty: the job has no list of operations
  std::size_t number = 1, count = 1;  ///< from 1; in the order of the list
};

/// What a cut's feed may be set to where it follows the engagement (`plan --optimise feed`).
struct FeedRange {
  Feed highest;         ///< no less than the job's feed of cuts; that: nothing is raised
  Feed lowest;          ///< no more than it
  double load = 1.0;    ///< share of the largest load at the job's own feed that no place goes over
  double change = 0.0;  ///< of the job's feed, a share per mm of way, at most; 0: no limit
  /// Thickest chip by the tool's cutting data, as the feed that makes it in a full slot, mm/min; 0: not
  /// known.
  double largest_chip = 0.0;
};

/// One operation of a job file, with all that the file says for all of them.
struct Job {
  std::string path;  ///< the file it came from
  OperationName operation;
  std::string stl_path;                  ///< resolved against the job file's folder
  double stl_unit_mm = 1.0;              ///< length of the STL's unit
  std::vector<std::string> bodies;       ///< of the part's file, by name; empty: all
  std::vector<std::string> avoid_faces;  ///< of the part, by name or colour ("#rrggbb"): the tool keeps off
  double avoid = 0.1;                    ///< by so much, mm
  std::vector<std::string> only_faces;   ///< of the part, likewise: they alone are machined; empty: all
  double beyond_faces = 0.0;             ///< passes go on so far beyond these, on a plane, mm
  /// Largest distance of the part's facets from its surfaces, mm; 0: the file holds facets. plan.tolerance is
  /// what is left.
  double tessellation = 0.0;
  std::string tools_path;  ///< of the tool library, resolved likewise; empty: the cutter is in the job
  std::string tool_id;     ///< as the machine's magazine has it; may be empty
  std::string material;    ///< whose cutting data are taken; empty: none
  pathgen::PlanOptions plan;
  Angle axis_tolerance;  ///< by which the axis may lean near the rotary's pole; 0: not at all
  Angle calm;            ///< by which it may lean so that tilt and table turn evenly; 0: not at all
  Setup setup;           ///< tool_length = plan.cutter.length
  std::vector<Fixture> fixtures;
  std::optional<Blank> blank;  ///< what the first operation cuts from; nothing: nobody says
  double spindle_rpm = 0.0;    ///< 0: no spindle words
  FeedRange feeds;
  ProgramData program;
  MachineProfile machine;
};

/// Typed directions are rounded, to five decimals as a rule: t and n may miss the right angle by this much
/// (rad) and are then made exactly perpendicular, t kept.
inline constexpr double kPerpendicularTolerance = 1e-5;

/// Reads the job, the machine profile and the tool library that it names.
/// Properties: every value is finite and in range; t, n are unit and perpendicular; `fixture` is a rotation,
/// exact for multiples of 90 degrees; 0 < approach <= clearance; height of the cutter's rounded end <=
/// cutting_end() <= shank_length <= length; the boundary is a polygon without crossings; what the kind of
/// pattern does not use has its default, and side_step is 0 where a scallop alone sets the step.
/// Errors: kInput as file:line:column, what was expected, the nearest known key; kIo; kUsage: the job has
/// several operations.
Result<Job> load_job(const std::string& path);
/// A job whose files lie elsewhere than its text says; empty: as the job says. `operation`: its name; empty:
/// the only one.
struct JobFiles {
  std::string stl = {}, machine = {}, tools = {}, operation = {};
  /// No other file is read or looked for than job, part, profile and what that names: one that the job names
  /// is an error, whatever it is. For jobs of others.
  bool closed = false;
};
/// Errors: as load_job; kUsage: there is no operation of that name.
Result<Job> load_job_with(const std::string& path, const JobFiles& files);
/// All operations, or the one that `files` names, in their order; at least one.
/// Properties: all have the same part, machine, set-up but for the tool's length, fixtures, work offset and
/// number of the program; one tool number is one cutter. Errors: as load_job_with.
Result<std::vector<Job>> load_operations(const std::string& path, const JobFiles& files);
/// The text of a job with its tool written out, for a place where the library is not; a text that names none
/// is as it was. Properties: reads as the same job. Errors: as load_job.
Result<std::string> with_tool_written_out(const std::string& text, const std::string& path,
                                          const JobFiles& files);
/// The same from text; `path` names it in messages and its folder is where relative paths start.
Result<Job> parse_job(const std::string& text, const std::string& path);
/// The resolved job and its machine, one `key: value` a line.
std::string describe(const Job& job);

/// What the control may leave the path by, mm: the plan has the rest of the job's tolerance.
inline double left_to_control(const Job& job) {
  return job.machine.format.blend_tolerance + job.program.smoothing_tolerance;
}

}  // namespace tiltfeed::config
