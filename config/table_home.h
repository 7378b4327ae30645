#pragma once
// The table at home: where TCP begins on a control that may count X Y Z from the table as it stands there.

#include <optional>
#include <string>
#include <vector>

#include "config/program_format.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed::config {

/// A rotary that carries the work.
struct TableTurn {
  const RotaryAxis* axis;
  double Joints::*word;
};
std::vector<TableTurn> table_turns(const MachineModel& machine);

/// The word at which the axis is at home, of those within its travel the one nearest to `word`, rounded; not
/// over an end of the travel by that.
std::optional<double> nearest_home(const RotaryAxis& axis, double word, int decimals);

/// Why TCP cannot begin with the table at home on such a control: a rotary of the table cannot stand there.
std::optional<std::string> no_home(const MachineModel& machine, const ProgramFormat& format);

}  // namespace tiltfeed::config
