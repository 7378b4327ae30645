#pragma once
// What has come to an end since the service began: for who watches it over months.

#include <cstdint>
#include <map>
#include <string>

namespace tiltfeed::daemon {

/// By outcome. Nothing is kept over a restart, as of counters that Prometheus reads.
struct ServiceCounts {
  using Count = std::map<std::string, std::uint64_t>;
  Count runs;  ///< done, stopped, failed, interrupted, uncertain, tool change, nothing sent
  /// Plans of this machine that others were asked for: accepted, refused, not taken.
  Count orders;
  Count helped;  ///< plans for others: done, failed, given back
};

}  // namespace tiltfeed::daemon
