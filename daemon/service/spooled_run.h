#pragma once
// What a run of a spooled job, and the ways at its tool changes, are made from.

#include <cstdint>
#include <string>

#include "config/machine_profile.h"
#include "daemon/journal/program_run.h"
#include "daemon/service/spool.h"

namespace tiltfeed::daemon {

/// What the ways off the part and back to it are made from.
struct WayOrder {
  std::string program, yaml, stl;  ///< files of the job
  LinkKind kind = LinkKind::kGrbl;
  config::MachineProfile machine;
  std::uint64_t change = 0;  ///< block of the tool change
};

/// The program as it lies there now, which must be the one that became ready. Errors: as prepare_run; kInput.
Result<ProgramRun> prepare_spooled(const SpooledJob& job, const std::string& program, const LinkSpec& link);

}  // namespace tiltfeed::daemon
