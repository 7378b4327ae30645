#pragma once
// The keys of a machine profile that say which axes turn work and tool, where they lie and how far they go.

#include "config/description.h"
#include "config/section.h"
#include "kinematics/machine.h"

namespace tiltfeed {

/// structure, tilt, rotary, table_centre_mm, pivot_to_gauge_mm, rotary_to_tilt_mm, spindle_direction.
void read_rotaries(const Section& root, MachineModel& model);
void describe_rotaries(Description& out, const MachineModel& model);

}  // namespace tiltfeed
