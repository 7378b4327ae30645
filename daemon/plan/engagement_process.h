#pragma once
// What the cutter has to do along a program that has no name yet: `tiltfeed-sim engagement` as a process of
// its own.

#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/joints/joint_path.h"

namespace tiltfeed::daemon {

struct EngagementRequest {
  std::string job, stl, machine, operation;  ///< as `tiltfeed plan` has them
  std::string stock;  ///< what the part is cut from; empty: as `tiltfeed verify` takes it
};

/// A row of its table: blocks are counted from their operation's last one, which is 0.
struct EngagedRow {
  std::uint64_t first_behind = 0, last_behind = 0;
  double first_share = 0.0, last_share = 1.0;
  double way = 0.0, chip = 0.0, edge_load = 0.0, turn_load = 0.0;
  double asked = 0.0, took = 0.0;  ///< s
};

/// By operation.
struct MeasuredEngagement {
  std::vector<std::vector<EngagedRow>> rows;
  std::vector<double> seconds;  ///< that the simulated machine takes
};

/// Measures the program that is in the file of this descriptor, whole and flushed. Errors: kIo: the process
/// is not there or does not start; kInput: what it says; kCancelled.
Result<MeasuredEngagement> measure_engagement(const EngagementRequest& request, int program,
                                              const StageProgress& progress);

}  // namespace tiltfeed::daemon
