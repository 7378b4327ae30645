#pragma once
// Feeds that follow the engagement: from what the cutter has to do along the program as it was planned to
// speeds, and whether the program at these speeds loads it no more.

#include <optional>
#include <string>
#include <vector>

#include "daemon/plan/engagement_process.h"
#include "daemon/plan/feed_profile.h"
#include "daemon/plan/operation_plan.h"

namespace tiltfeed::daemon {

/// What was found for an operation.
struct FollowedFeeds {
  bool kept = true;             ///< as it was planned: nothing else is quicker within the limits
  double seconds_before = 0.0;  ///< of the simulated machine
  double seconds = 0.0;
  std::size_t blocks_before = 0;
  Loads share;  ///< the largest loads, of those before
};

/// Errors: kInput: what of the job does not go with feeds that follow the engagement, and what to change.
Result<void> feeds_can_follow(const std::vector<const OperationPlan*>& operations);

/// What the link takes for a block, s; 0: not known.
double seconds_on_link(const config::MachineProfile& machine, const ProgramReport& program);

class EngagedFeeds {
 public:
  /// The engagement along the program at the job's own feeds; `posted`: it. Requires: feeds_can_follow().
  EngagedFeeds(std::vector<OperationPlan*> operations, const PlannedProgram& posted,
               const MeasuredEngagement& before);
  /// Gives the operations their speeds. `least_seconds`: of a block that is made shorter.
  void apply(double least_seconds);
  /// Whether no load of the program that was made with them is over its limit; else the next apply() keeps
  /// further below. After kTries attempts an operation is as it was.
  bool holds(const PlannedProgram& posted, const MeasuredEngagement& now);
  const std::vector<FollowedFeeds>& found() const { return found_; }

  static constexpr int kTries = 4;

 private:
  struct One {
    OperationPlan* plan = nullptr;
    std::vector<LoadSpan> spans;
    Loads before{};
    double margin = 1.0;  ///< of the limits, that the profile is made for
    bool given_up = false;
  };
  std::vector<One> operations_;
  std::vector<FollowedFeeds> found_;
  int tried_ = 0;
};

}  // namespace tiltfeed::daemon
