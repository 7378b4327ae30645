#pragma once
// How TCP begins on a control that may count X Y Z from the table as it stands there.

#include <optional>
#include <string>
#include <vector>

#include "config/machine_profile.h"

namespace tiltfeed::daemon {

/// A rotary that carries the work.
struct TableTurn {
  const RotaryAxis* axis;
  double Joints::*word;
};
std::vector<TableTurn> table_turns(const MachineModel& machine);
/// The word at which the axis is at home, of those within its travel the one nearest to `word`, rounded.
std::optional<double> nearest_home(const RotaryAxis& axis, double word, int decimals);

/// The words under TCP before an operation's first block, `first` its slides and rotaries. TCP begins at the
/// first of them, the table at home; then the table turns to its place. At the end of each block the slides
/// are where they were: X and Y those of `first`, Z the machine's tcp_start_below under the end of its
/// travel, or that of `first` where that is higher. Words, and slides at their ends, are rounded. Empty: the
/// control begins anywhere, or the table is at home. Requires: no_home() says nothing.
std::vector<Joints> tcp_start(const config::MachineProfile& machine, const Setup& setup, const Joints& first);
/// Why TCP cannot begin so: a rotary of the table cannot stand at home.
std::optional<std::string> no_home(const config::MachineProfile& machine, const Joints& first);

}  // namespace tiltfeed::daemon
