#pragma once
// What the machine's commands have in common: words, places, limits, refusals.

#include <optional>
#include <string>
#include <vector>

#include "daemon/machine/grbl_talk.h"
#include "daemon/machine/machine_bench.h"
#include "daemon/wire/axis_values.h"

namespace tiltfeed::daemon {

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
/// The percent of "WHICH 80", kMinOverride to kMaxOverride; nothing where it is none.
std::optional<int> override_percent(const OrderWords& words);
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
/// Homing takes no longer, s.
inline constexpr double kHomeTime = 600.0;
/// The F without one in the order, mm/min or degrees/min.
inline constexpr double kUsualJogFeed = 500.0;
/// The highest F that the axes of the profile allow for a way. `linear_first`: F is measured over X Y Z where
/// one of them moves (RepRap), else over all axes (Grbl).
double highest_feed(const MachineModel& machine, const AxisValues& way, bool linear_first);
/// Errors: kLimit: F is above that.
Result<void> feed_allowed(const MachineModel& machine, const AxisValues& way, double feed, bool linear_first);
/// "X+", "C- F500". Nothing: it is no continuous jog.
struct JogOn {
  char letter = ' ';
  double sign = 1.0;
  std::optional<double> feed;
};
Result<std::optional<JogOn>> continuous_jog(const OrderWords& words, const MachineModel& machine);

/// Ends what moves by feed hold and reset, and says where that leads.
Error stopped_by_operator(const MachineBench& bench, const char* what);

/// {"X":1.0,...} of the axes that are known.
std::string axes_json(const AxisValues& axes);

// The commands themselves, by the kind of controller.
Result<MachineAnswer> grbl_status(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_jog(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_home(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_unlock(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_offsets(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_probe(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_settings(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_console(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_override(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> grbl_tool(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_status(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_jog(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_home(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_unlock(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_offsets(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_settings(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_console(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_override(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> reprap_tool(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> ring_status(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> ring_unlock(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> ring_override(const MachineBench& bench, const OrderWords& words);
Result<MachineAnswer> drive_status(const MachineBench& bench, const OrderWords& words);

}  // namespace tiltfeed::daemon
