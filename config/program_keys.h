#pragma once
// The sections `program` of a machine profile and of a job.

#include <optional>

#include "config/description.h"
#include "config/program_format.h"
#include "config/section.h"

namespace tiltfeed::config {

/// `dialect`: if it is not the profile's, that dialect's defaults, with the profile's clamps and line
/// numbers.
ProgramFormat read_format(const Section& root, std::optional<Dialect> dialect);
/// Complains of TCP that cannot begin on this machine: as no_home().
void check_planes(const Section& root, const MachineModel& model, const ProgramFormat& format);
void check_home(const Section& root, const MachineModel& model, const ProgramFormat& format);
void describe_format(Description& out, const ProgramFormat& format);

/// `tool`: the number where the section states none.
ProgramData read_program_data(const Section& root, int tool = 0);
void describe_program_data(Description& out, const ProgramData& data);

}  // namespace tiltfeed::config
