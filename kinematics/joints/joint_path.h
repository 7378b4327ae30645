#pragma once
// Tool path to joint path: branch and C continuous, subdivided so that the tip as the machine really moves
// it (axes linear within a block) stays on the path, timed by feed and axis speeds. (K6), (K9), (K10).

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// Called now and then with the fraction done, from one thread at a time; false cancels.
using StageProgress = std::function<bool(double fraction)>;

/// Properties: 1 forward(joints) = pose within tolerance, on rapids kRapidToleranceFactor times that,
/// everywhere on every block. 2 No limit is broken. 3 |dC| < 180 degrees in every block. 4 C and branch are
/// continuous: the solution nearest to the joints before is taken, on C + 360 k within limits. 5 Near the
/// pole C is held, and turned in place where it must turn. 6 The same bits on any number of threads.
/// Where the first start leads into a limit, starts on other branches and turns are tried, then
/// reconfigurations with the tool off the part. An axis that turns over by 180 degrees within one move goes
/// by way of the pole.
/// Errors: kUnreachable, kLimit: the first pose, the axis with value and limit, and what to change; kInput: a
/// speed or feed that is 0, an axis that is not unit; kCancelled.
Result<JointPath> to_joints(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                            const JointPathOptions& options, const StageProgress& progress = {});

}  // namespace tiltfeed
