#pragma once
// What planning and posting did, as JSON for machines and a few lines for people.

#include <optional>
#include <string>
#include <vector>

#include "config/job.h"
#include "daemon/plan/proof_process.h"
#include "daemon/plan/start_turn.h"
#include "daemon/post/block.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/joints/singularity_bend.h"
#include "kinematics/timing/timing.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

struct PlanOutcome {
  const config::Job& job;
  const pathgen::CheckedMesh& part;
  const pathgen::PlanReport& plan;
  const SingularityBendReport& bend;
  const JointPathReport& joints;
  const ProgramReport& program;
  const Timing& timing;
  Starvation starved;
  std::optional<ProofFigures> proof;      ///< nothing: --no-proof
  std::optional<StartTurn> turn;          ///< nothing: the table does not turn where TCP begins
  std::vector<pathgen::StageTime> times;  ///< of all stages, in order
  double cpu_seconds = 0.0;
  double peak_memory_mb = 0.0;
};

/// What a program asks of the machine, whatever it was made from.
struct MotionOutcome {
  const MachineModel& machine;
  const JointPathReport& joints;
  const ProgramReport& program;
  const Timing& timing;
  const Starvation& starved;
};

/// Some lines: blocks, time, per-axis peaks, wind-up, reconfigurations, starvation, clamped feeds.
std::string motion_text(const MotionOutcome& outcome);

/// Where the machine would wait for blocks; nowhere when the profile does not state the link's rate.
Starvation starved(const Timing& timing, const config::MachineProfile& machine, const ProgramReport& program);

/// JSON, one key a line.
std::string report_json(const PlanOutcome& outcome);
/// A screenful.
std::string report_text(const PlanOutcome& outcome);

}  // namespace tiltfeed::daemon
