#pragma once
// What planning and posting did, as JSON for machines. For people: plan_text.h.

#include <optional>
#include <string>
#include <vector>

#include "daemon/plan/avoidance.h"
#include "daemon/plan/engaged_feeds.h"
#include "daemon/plan/operation_plan.h"
#include "daemon/plan/proof_process.h"
#include "daemon/plan/time_report.h"
#include "daemon/post/block.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/timing/timing.h"
#include "pathgen/part_file/part_model.h"

namespace tiltfeed::daemon {

struct PlanOutcome {
  std::vector<const OperationPlan*> operations;  ///< at least one
  const pathgen::PartModel& model;               ///< of the first, without facets
  const pathgen::CheckedMesh& part;
  const ProgramReport& program;
  const Timing& timing;  ///< of all operations
  Starvation starved;
  std::optional<ProofFigures> proof;          ///< nothing: --no-proof
  std::optional<Avoidance> avoidance;         ///< nothing: the first program was proven, or none asked
  std::vector<ShortenedOperation> shortened;  ///< by operation; empty: not asked
  std::vector<FollowedFeeds> feeds;           ///< likewise
  std::vector<pathgen::StageTime> times;      ///< of all stages, in order
  double cpu_seconds = 0.0;
  double peak_memory_mb = 0.0;
};

/// As it is proven: the plan leaves a part of it to arcs, mm.
double whole_tolerance(const config::Job& job);
/// How far the rotary winds up, turns.
double rotary_turns(const JointPathReport& joints);

/// Where the machine would wait for blocks; nowhere when the profile does not state the link's rate.
Starvation starved(const Timing& timing, const config::MachineProfile& machine, const ProgramReport& program);

/// JSON, one key a line. Of several operations what each has by itself is in the list `operations`.
std::string report_json(const PlanOutcome& outcome);

}  // namespace tiltfeed::daemon
