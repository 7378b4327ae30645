#pragma once
// Planning in a process of its own: what it does wrong or for too long touches no machine.

#include <cstdint>
#include <optional>
#include <string>

#include "config/child_process.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct PlanProcess {
  config::ChildProcess process;
  std::uint64_t job = 0;
  std::string folder;
  bool runs() const { return process.runs(); }
};

/// Starts `tiltfeed plan` on FOLDER/job.yaml with FOLDER/part.stl for this machine; writes program.nc,
/// path.cls, report.json, block.map and plan.log there. It ends with what it returns. Errors: kIo.
Result<PlanProcess> start_plan(std::uint64_t job, const std::string& folder, const std::string& machine);
/// Where memory runs out the kernel ends this process before any other: not the service, which has the
/// machine.
void give_up_first(int pid);
/// Nothing while it runs; afterwards how it ended: an error with the last line that it said.
std::optional<Result<void>> check_plan(PlanProcess& process);
/// What the planner of this folder is at: percentage and stage; nothing where that is not known yet.
struct PlanStage {
  int percent = 0;
  std::string stage;
};
std::optional<PlanStage> stage_of(const std::string& folder);
/// Ends it, if there is one.
void stop_plan(PlanProcess& process);

}  // namespace tiltfeed::daemon
