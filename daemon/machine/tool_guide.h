#pragma once
// A tool change in the middle of a program, asked for line by line: the same over a link of its own and
// through the service.

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>

#include "daemon/machine/machine_guides.h"
#include "daemon/program/tool_change.h"

namespace tiltfeed::daemon {

struct ToolGuide {
  std::string title;  ///< what stands where
  bool wants_length = false;
  std::string orders = {};  ///< of the machine, as orders_in_change() has them
  MachineAct act;           ///< of the machine's commands
  std::function<Result<std::string>(double length)> take_length;  ///< says how it compares with the program's
  std::function<Result<std::string>()> way_back;                  ///< what would move, for the operator
};

/// Before the way back to the part.
inline constexpr const char* kBackQuestion = "Is the tool clear, are the clamps shut? Type yes to move: ";

/// Shows, waits for the tool, takes or measures its length, shows the way back. Takes the machine's commands
/// in between (jog X10, tool measure Z-30 setter=-120.5, tool park). Done: the operator has said "go".
/// Errors: kCancelled: "quit", or nobody answers any more.
Result<void> guide_tool_change(const ToolGuide& guide, std::istream& in, std::ostream& out);

}  // namespace tiltfeed::daemon
