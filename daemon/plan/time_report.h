#pragma once
// Lines of the plan's report about the program's time: where it goes, what is left to gain, what was gained.

#include <optional>
#include <string>
#include <vector>

#include "daemon/plan/operation_plan.h"

namespace tiltfeed::daemon {

/// What was tried to shorten an operation's time.
struct ShortenedOperation {
  double seconds = 0.0;                     ///< of the job's own pattern
  std::size_t tried = 0;                    ///< other plans
  std::optional<pathgen::Pattern> pattern;  ///< that is quicker; nothing: none
  std::optional<pathgen::AxisFrame> frame;  ///< with it, where that is another
  double join_distance = 0.0;               ///< with measure ridge, mm
  Angle calm;                               ///< with it, where the axis leans for even turns
  std::uint32_t rounds = 0;                 ///< with it, where closed rows are joined without turning back
  bool own_ridges = false;  ///< were rows tried by ridges, and no higher than most of the job's own?
};

/// By how much each operation was shortened, and by which keys; a line each. Empty where none was to be.
std::string shortened_text(const std::vector<const OperationPlan*>& operations,
                           const std::vector<ShortenedOperation>& shortened);
/// What of the program's time is left to gain, and where. `machine`: that of the operations.
std::string bounds_text(const std::vector<const OperationPlan*>& operations, const MachineModel& machine);
/// Where its minutes go.
std::string by_motion_text(const std::vector<const OperationPlan*>& operations);

}  // namespace tiltfeed::daemon
