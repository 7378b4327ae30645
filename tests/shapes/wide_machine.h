#pragma once
// A machine that can do whatever a test program asks for.

#include "kinematics/machine/machine.h"

namespace tiltfeed {

inline MachineModel wide_machine(const char* name = "") {
  MachineModel machine;
  machine.name = name;
  for (LinearAxis* axis : {&machine.x, &machine.y, &machine.z}) *axis = {-1000, 1000, 1e7, 1e7};
  for (RotaryAxis* axis : {&machine.tilt, &machine.rotary}) {
    axis->min = -1e6;
    axis->max = 1e6;
    axis->velocity = axis->acceleration = 1e9;
  }
  machine.rotary.letter = 'C';
  machine.rotary.direction = {0, 0, 1};
  machine.pivot_to_gauge = {0, 0, -100};
  return machine;
}

}  // namespace tiltfeed
