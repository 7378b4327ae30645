#pragma once
// The passes of a predefined axis with leans where shank or holder would come too near. (Y1) to (Y6) in
// pathgen/lean/README.md.

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "pathgen/envelope/pass.h"
#include "pathgen/lean/lean_tool.h"
#include "pathgen/linking/link_options.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

/// What one thing keeps the tool from.
struct HeldBy {
  double length = 0.0;  ///< of passes left out, mm
  std::uint64_t places = 0;
  Point<Part> first;                  ///< of the CL reference
  std::vector<std::uint32_t> facets;  ///< of the mesh, those that were met; each once, ascending
};

struct LeanFigures {
  double leaned = 0.0;                       ///< of the passes, with a lean, mm
  double left = 0.0;                         ///< left out, mm
  double largest = 0.0;                      ///< lean, rad
  HeldBy shank, holder;                      ///< held by the part
  std::map<std::uint32_t, HeldBy> fixtures;  ///< by body
};

/// Gives the points of the passes the tool axes that they need, as little off the mode's as does, and leaves
/// out what no lean clears; passes come to lie in pieces, which keep their order. Passes that need no lean
/// are as they were. Requires: shank and holder are heeded nowhere yet, the cutting part everywhere.
/// Properties: 1 The tool is clear all along every move, and can be drawn back from every place. 2 No lean is
/// over the limit, and none changes faster than it may. 3 The CL reference stays on the straight moves
/// between the passes' points. 4 At both ends of a piece leaned_end() gives a way. 5 The same for any number
/// of threads. When the user stops it, what it returns is worth nothing.
LeanFigures lean_passes(const LeanTool& tool, std::vector<std::vector<Pass>>& rows,
                        const ReportShare& report = {});

/// How a tool that leans at the end of a pass comes there and away; nothing where it cannot, or stands on the
/// mode's axis.
std::optional<LeanedEnd> leaned_end(const LeanTool& tool, const EnvelopePoint& end);

/// The points of a join, from `a` over `between` (on the mode's axis) to `b`, with leans that change evenly
/// from that of `a` to that of `b`; without both. Nothing where the tool is not clear, or would turn too
/// fast.
std::optional<Pass> leaned_join(const LeanTool& tool, const EnvelopePoint& a, const Pass& between,
                                const EnvelopePoint& b);

}  // namespace tiltfeed::pathgen
