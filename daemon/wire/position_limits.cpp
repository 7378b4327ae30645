#include "daemon/wire/position_limits.h"

namespace tiltfeed::daemon {

PositionLimits position_limits(const config::PositionTolerance& tolerance, const MachineModel* machine) {
  PositionLimits limits;
  limits.tolerance = tolerance;
  if (machine == nullptr) return limits;
  const auto set = [&](std::size_t axis, double low, double high) {
    limits.low[axis] = low;
    limits.high[axis] = high;
  };
  set(0, machine->x.min, machine->x.max);
  set(1, machine->y.min, machine->y.max);
  set(2, machine->z.min, machine->z.max);
  for (const RotaryAxis* axis : {&machine->tilt, &machine->rotary})
    if (const std::size_t at = kAxisLetters.find(axis->letter); at != kAxisLetters.npos) {
      limits.modulo[at] = axis->word != RotaryWord::kAccumulate;
      if (!limits.modulo[at]) set(at, axis->min, axis->max);
    }
  return limits;
}

}  // namespace tiltfeed::daemon
