#pragma once
// check_mesh() with the share of it that is done, for those who show it.

#include "pathgen/mesh/mesh.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed {

/// As check_mesh() without `report`. Errors: kCancelled, too.
Result<CheckedMesh> check_mesh(const Stl& stl, const RepairOptions& options, const ReportShare& report);

}  // namespace tiltfeed
