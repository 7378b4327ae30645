#pragma once
// Passes of the envelope to one tool path: order, direction, and the moves through clear air between them.

#include <cstdint>
#include <vector>

#include "kinematics/tool_path.h"
#include "pathgen/envelope.h"
#include "pathgen/far_side.h"
#include "pathgen/plan_options.h"

namespace tiltfeed {

struct Linking {
  Direction direction = Direction::kZigzag;
  double reference_height = 0.0;  ///< of the CL reference over the tip, mm
  double clearance_z = 0.0;       ///< z' of the clearance surface, mm
  double clearance = 0.0;         ///< of the clearance surface over what it clears, mm
  double approach = 0.0;          ///< last part of an approach, at plunge feed, mm
};

struct Linked {
  std::vector<Move> moves;
  std::uint64_t skipped_passes = 0;  ///< to which no clear travel was found
};

/// The moves over all passes, slice by slice. Between passes the tool retracts along its axis to the
/// clearance surface (constant z' = clearance_z), travels there, comes down along the new axis, and plunges
/// the last `approach`. A pass whose travel `far_side` finds blocked is left out. (L1), (L2) in
/// pathgen/README.md.
Linked link(const std::vector<std::vector<Pass>>& slices, const ClSurface& surface,
            const Deformation& deformation, const Linking& options, FarSide& far_side);

}  // namespace tiltfeed
