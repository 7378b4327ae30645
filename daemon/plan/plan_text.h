#pragma once
// What planning and posting did, in a few lines for people.

#include <string>

#include "daemon/plan/plan_report.h"

namespace tiltfeed::daemon {

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

/// A screenful.
std::string report_text(const PlanOutcome& outcome);

}  // namespace tiltfeed::daemon
