#pragma once
// The way of the axes from one stretch of a program to the next: the tool at the end of Z's travel, where the
// profile's retract brings it, the rotaries to their place, X and Y to theirs.

#include <array>
#include <cstdint>
#include <vector>

#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed::daemon {

enum class SwingOrder : std::uint8_t {
  kTogether,     ///< both rotaries at once
  kTiltFirst,    ///< the tilt, then the rotary
  kRotaryFirst,  ///< the rotary, then the tilt
  kOverHome,     ///< the tilt to its home, the rotary, the tilt
};

struct SwingWay {
  SwingOrder order = SwingOrder::kTogether;
  /// X and Y go before the rotaries, over home between the tilt's way home and the rotary's.
  bool across_first = false;

  bool operator==(const SwingWay&) const = default;
};

/// Where the axes stop on their way: the last place is `to`. Z stays as `from` has it. Property: no axis goes
/// back on its way but the tilt over home. Places that are one with that before are left out.
std::vector<Joints> swing_places(const MachineModel& machine, const Joints& from, const Joints& to,
                                 SwingWay way);

/// What the machine does between two stretches: up to the end of Z's travel, then swing_places(); rapids,
/// without the last one down.
std::vector<JointMove> moves_between(const MachineModel& machine, const Joints& from, const Joints& to,
                                     SwingWay way = {});

}  // namespace tiltfeed::daemon
