#pragma once
// Ways of the axes between two stretches of a program, behind a retract: in another order, the other way
// round, to the tilt's other side.

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "daemon/post/swing.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

struct SwingChoice {
  SwingWay way;
  bool other_side = false;  ///< in the stretch behind the tilt leans to its other side of home
  bool other_way = false;  ///< the rotary turns the other way round, and the stretch behind is a turn further
};

inline constexpr std::size_t kSwingOrders = 4;

/// In the order in which they are tried: orders of the axes, then these the other way round, then both on the
/// tilt's other side. The first is the planned way.
constexpr std::array<SwingChoice, 8 * kSwingOrders> swing_choices() {
  std::array<SwingChoice, 8 * kSwingOrders> all{};
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t order = i % kSwingOrders, rest = i / kSwingOrders;
    all[i] = {{static_cast<SwingOrder>(order), rest % 2 == 1}, rest / 4 == 1, rest / 2 % 2 == 1};
  }
  return all;
}
inline constexpr std::array<SwingChoice, 8 * kSwingOrders> kSwingChoices = swing_choices();

/// Where the stretch behind begins then. `usual`: where it does as planned. Nothing: the machine cannot.
std::optional<Joints> swung(const MachineModel& machine, const Setup& setup, const Joints& from,
                            const Joints& usual, const SwingChoice& choice);

/// Whole turns of the rotary, degrees, that make it turn the other way round; nothing where it does not turn,
/// or its words cannot count turns.
std::optional<double> turn_round(const MachineModel& machine, const Joints& from, const Joints& to);

/// Whether a choice makes another way than those before it in kSwingChoices.
bool differs(const MachineModel& machine, const Setup& setup, const Joints& from, const Joints& usual,
             std::size_t choice);

}  // namespace tiltfeed::daemon
