#pragma once
// The ways off the part before a tool change and back to it afterwards, as small programs of their own:
// nothing of the program that is changed in is repeated.

#include <cstdint>
#include <string>

#include "config/machine_profile.h"
#include "daemon/program/link_kind.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct ReturnOptions {
  std::uint64_t change = 0;    ///< block of the tool change
  double retract = 50.0;       ///< height along the tool axis that is plunged at last, mm
  double plunge_feed = 200.0;  ///< mm/min
  double spindle_delay = 3.0;  ///< seconds until the spindle turns
  Setup setup;                 ///< of the job; where it is not known, of a tool without length
};

struct ToolWay {
  std::string program;
  std::string preview;  ///< the same, a line each, for the operator
};

/// Along the tool axis first, where the program has said where all axes are and the travel allows it; spindle
/// and coolant off; the profile's retract line. Errors: as plan_return.
Result<ToolWay> plan_park(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                          const ReturnOptions& options);

/// Order: the profile's retract line, rotaries as programmed, X Y over the place where the program stands,
/// spindle and coolant that are on there, down to `retract` over the highest place of the program so far,
/// then at plunge feed and along the tool axis, the modes. An axis that
/// the program has sent to a place of the machine's own (G53) goes there. One that it has not stated stays
/// where it is, and so does Z then. Errors: kIo, kInput (a line that is not understood), kUsage (no retract
/// line), kLimit (a step leaves the travel).
Result<ToolWay> plan_return(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                            const ReturnOptions& options);

}  // namespace tiltfeed::daemon
