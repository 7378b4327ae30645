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
  std::string folder, log;  ///< log: its name in the folder
  bool runs() const { return process.runs(); }
};

/// Starts `tiltfeed plan` on FOLDER/job.yaml with FOLDER/part.stl for this machine; writes program.nc,
/// path.cls, report.json, block.map and plan.log there. It ends with what is returned. Errors: kIo.
Result<PlanProcess> start_plan(std::uint64_t job, const std::string& folder, const std::string& machine);
/// The profile of another machine, beside the job that is planned for it.
inline constexpr const char* kForeignProfile = "machine.yaml";
/// The same for another machine of the shop, FOLDER/machine.yaml: at the lowest priority, and no file but
/// these three is read.
Result<PlanProcess> start_foreign_plan(const std::string& folder);
/// Starts `tiltfeed-sim prove` of FOLDER/program.nc against FOLDER/job.yaml, FOLDER/part.stl and this
/// machine; writes proof.log there. Errors: kIo.
Result<PlanProcess> start_proof(std::uint64_t job, const std::string& folder, const std::string& machine);
/// After a proof that has found no fault: it has found as many moves, and the same largest gouge, as the
/// program's header states. A program for another machine, or of other lines, states others. Errors: kInput.
Result<void> compare_figures(const std::string& folder);
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
