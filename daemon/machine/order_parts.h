#pragma once
// What the machine's commands have in common: words, places, limits, refusals.

#include <optional>
#include <string>
#include <vector>

#include "daemon/machine/grbl_talk.h"
#include "daemon/machine/machine_bench.h"
#include "daemon/wire/axis_values.h"

namespace tiltfeed {

using OrderWords = std::vector<std::string>;

/// A letter and a number, as. Errors: kUsage.
struct AxisWord {
  char letter = ' ';
  double value = 0.0;
};
Result<AxisWord> axis_word(const std::string& text);
/// Words of axes that this machine has, and F. Errors: kUsage.
struct AxisWords {
  AxisValues axes = no_axes();
  std::optional<double> feed;
  std::string letters;  ///< of the axes named, in their order
};
Result<AxisWords> axis_words(const OrderWords& words, const MachineModel& machine);
/// A number of three decimals.
std::string figure(double value);

/// What the profile says of an axis; nothing where it has none.
struct AxisTravel {
  double min = 0.0, max = 0.0, velocity = 0.0, acceleration = 0.0;
  bool rotary = false;
};
std::optional<AxisTravel> travel_of(const MachineModel& machine, char letter);
/// Errors: kLimit: an axis of `to`, program coordinates, is beyond the profile's travel.
Result<void> within_travel(const MachineModel& machine, const AxisValues& to);

/// Where the axes are, in machine and in program coordinates: not a number where it is not known.
struct MachinePlace {
  AxisValues machine = no_axes(), program = no_axes();
};
MachinePlace place_of(const GrblStatus& status, const GrblTalk& talk, const MachineModel& machine);

/// An idle machine with a known program position. Errors: kLink with its state in words and what to do.
Result<GrblStatus> idle_machine(GrblTalk& talk, const char* command);
/// The line was taken. Errors: kLink with the controller's number in words.
Result<GrblAnswer> obeyed(Result<GrblAnswer> answer, const std::string& line);
/// Ends what moves by feed hold and reset, and says where that leads.
Error stopped_by_operator(const MachineBench& bench, const char* what);

/// Over a ring: its alarm is cleared; its feed override. Errors: kUsage, kLink.
Result<MachineAnswer> unlock_ring(const MachineBench& bench);
Result<MachineAnswer> override_ring(const MachineBench& bench, const OrderWords& words);

/// {"X":1.0,...} of the axes that are known.
std::string axes_json(const AxisValues& axes);

// The commands themselves, by family.
Result<MachineAnswer> order_status(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_reset(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_jog(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_home(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_unlock(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_offsets(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_probe(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_settings(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_console(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_override(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> order_tool(const MachineBench& bench, const OrderWords& words);

}  // namespace tiltfeed
