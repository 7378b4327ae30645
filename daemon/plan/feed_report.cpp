#include "daemon/plan/feed_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/plan/formatted.h"

namespace tiltfeed::daemon {

std::string feeds_json(const std::vector<FollowedFeeds>& feeds,
                       const std::vector<const OperationPlan*>& operations) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    const FollowedFeeds& one = feeds[i];
    all.push_back({{"kept", one.kept},
                   {"machine_seconds_before", one.seconds_before},
                   {"machine_seconds", one.seconds},
                   {"blocks_before", one.blocks_before},
                   {"blocks", operations[i]->joints().moves.size()},
                   {"largest_chip", one.share.chip},
                   {"largest_edge_load", one.share.edge_load},
                   {"largest_turn_load", one.share.turn_load}});
  }
  return all.dump();
}

std::string feeds_text(const std::vector<FollowedFeeds>& feeds,
                       const std::vector<const OperationPlan*>& operations) {
  std::string text;
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    const FollowedFeeds& one = feeds[i];
    const std::string& name = operations[i]->job().operation.name;
    text += "feed by engagement" + (name.empty() ? name : ", " + name) + ": ";
    if (one.kept) {
      text += "nothing is quicker within the largest loads; the feeds are the job's\n";
      continue;
    }
    text += formatted(
        "the simulated machine takes %.1f min instead of %.1f; largest chip %.3f, load on an edge %.3f, over "
        "a "
        "turn %.3f of those before; %zu blocks instead of %zu\n",
        one.seconds / 60.0, one.seconds_before / 60.0, one.share.chip, one.share.edge_load,
        one.share.turn_load, operations[i]->joints().moves.size(), one.blocks_before);
  }
  return text;
}

}  // namespace tiltfeed::daemon
