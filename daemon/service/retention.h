#pragma once
// Which jobs of a spool have been kept for long enough.

#include <cstdint>
#include <vector>

#include "config/service_config.h"

namespace tiltfeed::daemon {

inline constexpr std::int64_t kDay = 24 * 3600;  ///< s

struct KeptJob {
  std::uint64_t id = 0;
  bool ended = false;      ///< done, stopped or failed, and in no queue: the others never go
  std::int64_t since = 0;  ///< end of its last run, else when it came; seconds since 1970
  std::uint64_t bytes = 0;
};

struct Outdated {
  std::uint64_t id = 0;
  bool by_age = true;  ///< else by size
};

/// Those that go, the oldest end first. Properties: none that has not ended; every ended one that is older
/// than `limits.days`; of the rest as few as bring the files of all jobs down to `limits.mib`, and none of
/// them ended after one that stays. Pure.
std::vector<Outdated> outdated(std::vector<KeptJob> jobs, const config::Retention& limits, std::int64_t now);

}  // namespace tiltfeed::daemon
