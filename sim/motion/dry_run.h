#pragma once
// A program run on the simulated axes without a wire: fed as fast as they take it.

#include <string>
#include <vector>

#include "sim/motion/motion.h"

namespace tiltfeed::sim {

struct DryRun {
  std::vector<TraceRow> rows;  ///< as the trace of tiltfeed-sim
  MotionTotals totals;
};

/// The axes know options.look_ahead blocks ahead (0: the whole program). M0 does not wait.
/// Errors: kLimit when a block leaves the machine's travel: `name`, line, axis.
Result<DryRun> dry_run(const std::vector<Block>& program, const std::string& name,
                       const MachineModel& machine, const Setup& setup, const MotionOptions& options);

/// The blocks that a machine executed, once more, with very many known ahead: what its time could have been.
/// The difference is what was lost to a short look-ahead and to a host that was late.
class ReferenceRun {
 public:
  ReferenceRun(const MachineModel& machine, const Setup& setup, MotionOptions options);
  void take(const TraceRow& row);
  /// Machine time of all that was taken, s. To be called once, at the end.
  double seconds();

 private:
  Motion motion_;
};

}  // namespace tiltfeed::sim
