#pragma once
// Shank and holder: a second envelope by the same code, of what may come near them where the passes run.
// (G1), (G2) in pathgen/pattern/README.md.

#include <memory>
#include <vector>

#include "pathgen/pattern/pass_depth.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// The field of the cutting part with the patches of shank and holder that can keep the tool off the part
/// anywhere on these passes, or wherever else `passes` says that they are known; nothing where there are
/// none. `reported`: those with Reaction::kReport, else the others. `passes` are those of `field`. When the
/// user stops it through `report`, what it returns is worth nothing; so with find_touches().
std::unique_ptr<const ClField> holder_field(const ClField& field, const PlanOptions& options,
                                            const PassDepth& passes, bool reported,
                                            const ReportShare& report = {});

/// What shank and holder cut into, where they only report.
struct Touches {
  std::uint64_t points = 0;
  std::vector<std::uint32_t> facets;  ///< of the STL, ascending, each once
};
Touches find_touches(const ClField& guarded, const EnvelopeOptions& options, const Passes& passes,
                     const ReportShare& report = {});

}  // namespace tiltfeed::pathgen
