#pragma once
// Passes of the envelope to one tool path: order, direction, and the moves between them, on the envelope or
// through clear air. (L1)..(L6) in pathgen/linking/README.md.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/basics/units.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/linking/link_options.h"
#include "pathgen/linking/opposite_wall.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// The moves over all passes. A pass whose start is near the end of the one before is joined to it on the
/// envelope, if that is clear and saves time; such moves cut. Otherwise the tool retracts along its axis to
/// the clearance surface (constant z' = clearance_z), travels there within the tilt limit, comes down along
/// the new axis, and plunges the last `approach`. With lead_radius a tangential arc, at plunge feed as it is
/// not in contact, stands between plunge and pass, and between pass and retract.
/// Properties: 1 each pass is travelled once, in the direction that `direction` asks, or counted as left out;
/// 2 air is never longer than slice by slice with as many passes; with PassOrder::kTimed all moves take no
/// longer, about (LinkTime::of). Requires: `envelope` is that of `field`; unless the order is kGiven, passes
/// of a slice lie in rising order on a straight flat line, and slices side by side.
Linked link(const std::vector<std::vector<Pass>>& slices, const ClField& field, const Linking& options,
            OppositeWall& opposite_wall, Envelope& envelope);

}  // namespace tiltfeed::pathgen
