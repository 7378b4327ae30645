#include "daemon/plan/swing_choice.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::daemon {

std::optional<double> turn_round(const MachineModel& machine, const Joints& from, const Joints& to) {
  const double turn = to.c - from.c;
  if (!machine.rotary.present || machine.rotary.word != RotaryWord::kAccumulate || turn == 0.0)
    return std::nullopt;
  return -std::copysign(360.0, turn);
}

std::optional<Joints> swung(const MachineModel& machine, const Setup& setup, const Joints& from,
                            const Joints& usual, const SwingChoice& choice) {
  Joints to = usual;
  if (choice.other_side) {
    const double lean = usual.a - machine.tilt.zero;
    if (!machine.tilt.present || lean == 0.0) return std::nullopt;
    const auto solutions = inverse(machine, setup, forward(machine, setup, usual), usual.c);
    if (!solutions) return std::nullopt;
    const auto other = std::find_if(solutions->begin(), solutions->end(), [&](const Joints& one) {
      return (one.a - machine.tilt.zero) * lean < 0.0;
    });
    if (other == solutions->end()) return std::nullopt;
    to = *other;
  }
  if (choice.other_way) {
    const auto turns = turn_round(machine, from, to);
    if (!turns) return std::nullopt;
    to.c += *turns;
  }
  if (choice.way.order == SwingOrder::kOverHome) {
    Joints home = from;
    home.a = machine.tilt.zero;
    if (!machine.tilt.present || broken_limit(machine, home)) return std::nullopt;
  }
  if (broken_limit(machine, to)) return std::nullopt;
  return to;
}

bool differs(const MachineModel& machine, const Setup& setup, const Joints& from, const Joints& usual,
             std::size_t choice) {
  const auto places = [&](const SwingChoice& one) -> std::optional<std::vector<Joints>> {
    const auto to = swung(machine, setup, from, usual, one);
    if (!to) return std::nullopt;
    return swing_places(machine, from, *to, one.way);
  };
  const auto own = places(kSwingChoices[choice]);
  return own &&
         std::none_of(kSwingChoices.begin(), kSwingChoices.begin() + static_cast<std::ptrdiff_t>(choice),
                      [&](const SwingChoice& one) { return places(one) == own; });
}

}  // namespace tiltfeed::daemon
