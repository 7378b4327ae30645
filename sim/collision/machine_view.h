#pragma once
// Machine and fixtures as numbers for a page that draws them: what each axis moves, solids by link. The form
// is in sim/collision/README.md.

#include <string>

#include "config/job.h"

namespace tiltfeed::sim {

/// Solids are those of the check of collisions. Errors: those of the STL files of bodies and fixtures, by
/// their names.
Result<std::string> machine_view(const config::Job& job);

/// `tiltfeed-sim machine`.
struct MachineViewOptions {
  std::string job, machine, out;
};
/// Errors: as machine_view(); kUsage: `out` is an input; kIo.
Result<void> machine_view_command(const MachineViewOptions& options);

}  // namespace tiltfeed::sim
