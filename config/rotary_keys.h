#pragma once
// The keys of a machine profile that say which axes turn work and tool, where they lie and how far they go.

#include "config/description.h"
#include "config/program_format.h"
#include "config/section.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::config {

/// structure, tilt and rotary (either may be absent where the structure is table-head), table_centre_mm,
/// pivot_to_gauge_mm, rotary_to_tilt_mm, spindle_direction.
void read_rotaries(const Section& root, MachineModel& model);
/// Complains at tilt.word or rotary.word where programs of the control cannot say it.
void check_rotary_words(const Section& root, const MachineModel& model, Dialect dialect);
void describe_rotaries(Description& out, const MachineModel& model);

}  // namespace tiltfeed::config
