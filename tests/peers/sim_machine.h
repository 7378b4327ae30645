#pragma once
// A small machine for the tests of the simulated controllers: 1 m of travel, a metre a second, and no limit
// of acceleration, so that blocks take the times that their words state.

#include "kinematics/machine/machine.h"

namespace tiltfeed::sim {

inline MachineModel test_machine() {
  MachineModel machine;
  machine.name = "test";
  for (LinearAxis* axis : {&machine.x, &machine.y, &machine.z}) *axis = {-500, 500, 60000};
  machine.tilt = {'A', {1, 0, 0}, +1, 0, -110, 110, 36000};
  machine.rotary = {'C', {0, 0, 1}, -1, 0, -36000, 36000, 36000};
  machine.pivot_to_gauge = {0, 0, -150};
  return machine;
}

}  // namespace tiltfeed::sim
