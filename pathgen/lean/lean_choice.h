#pragma once
// Which way, and how far, the tool leans along a stretch of a pass: the sequence of least lean that turns no
// faster than it may. (Y4) in pathgen/lean/README.md.

#include <optional>
#include <vector>

#include "pathgen/lean/lean_run.h"

namespace tiltfeed::pathgen {

/// Of a pass, mm along it, with the leans that the tool has where it comes from and goes on to; nothing: any.
struct LeanStretch {
  double from = 0.0, to = 0.0;
  std::optional<LeanAngle> first{}, last{};
};

/// The runs in which the tool goes along the stretch, clear all along, with leans up to options.lean.limit
/// that change by options.lean.max_turn at most. What no run has no lean clears, or no run of them that turns
/// slowly enough.
/// Leans are sought at places at most `spacing` (mm) apart.
std::vector<LeanedRun> lean_along(const LeanTool& tool, const PassFrames& frames, const LeanStretch& stretch,
                                  double spacing);

/// The usual distance of such places, mm.
double lean_spacing(const LeanTool& tool);

}  // namespace tiltfeed::pathgen
