#pragma once
// What feeds that follow the engagement gave: for the report's JSON and its text.

#include <string>
#include <vector>

#include "daemon/plan/engaged_feeds.h"

namespace tiltfeed::daemon {

/// A JSON list, an object for each operation.
std::string feeds_json(const std::vector<FollowedFeeds>& feeds,
                       const std::vector<const OperationPlan*>& operations);
/// A line for each operation.
std::string feeds_text(const std::vector<FollowedFeeds>& feeds,
                       const std::vector<const OperationPlan*>& operations);

}  // namespace tiltfeed::daemon
