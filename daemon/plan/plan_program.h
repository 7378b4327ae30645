#pragma once
// The way from a job to a proven program, in order: part, path, joints, program, proof, report. One function,
// for the command line and for the process that a service starts.

#include <string>
#include <vector>

#include "config/job.h"
#include "config/output_file.h"
#include "daemon/plan/stage_clock.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Empty: as the job says, or not wanted.
struct PlanFiles {
  std::string job, program, cl, report, map, stl, machine;
  std::string operation;               ///< of the job, alone; empty: all of them, in one program
  std::string gouge_picture;           ///< PNG, where the program is not proven
  std::string drawing;                 ///< the blocks for a viewer, see path_drawing.h
  bool prove = true, as_json = false;  ///< as_json: of what is returned
  bool shortest_time = false;          ///< the pattern may be another that leaves no more and is quicker
  bool engaged_feeds = false;          ///< the feed of cuts follows what the cutter has to do
  std::string stock;                   ///< with engaged_feeds: as `tiltfeed verify` has it
  bool alone = false;                  ///< only text and part came along: other files are refused
  bool closed = false;                 ///< only text, part and profile did: likewise
};

/// What is written, by the options that name it.
std::vector<config::NamedFile> outputs_of(const PlanFiles& files);

/// What goes to a service of a job: its text and its part. Errors: kInput: it has a fixture of a file.
Result<void> goes_alone(const config::Job& job);

/// Plans, posts and proves. Returns a screenful on what was done, or the
/// report as JSON. Files appear when all of them are written,
/// or not at all. Errors: those of each stage; kUsage: files that may not be outputs; kInput: the program
/// gouges, with line, place, facet and depth; kCancelled.
Result<std::string> plan_program(const PlanFiles& files, const PlanListener& listener);

}  // namespace tiltfeed::daemon
