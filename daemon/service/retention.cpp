#include "daemon/service/retention.h"

#include <algorithm>
#include <tuple>

namespace tiltfeed::daemon {

namespace {

constexpr int kMibBits = 20;

}  // namespace

std::vector<Outdated> outdated(std::vector<KeptJob> jobs, const config::Retention& limits, std::int64_t now) {
  std::uint64_t bytes = 0;
  for (const KeptJob& job : jobs) bytes += job.bytes;
  std::erase_if(jobs, [](const KeptJob& job) { return !job.ended; });
  std::sort(jobs.begin(), jobs.end(), [](const KeptJob& a, const KeptJob& b) {
    return std::tie(a.since, a.id) < std::tie(b.since, b.id);
  });
  std::vector<Outdated> gone;
  for (const KeptJob& job : jobs) {
    const bool old = limits.days > 0 && now - job.since > limits.days * kDay;
    const bool large = limits.mib > 0 && bytes > static_cast<std::uint64_t>(limits.mib) << kMibBits;
    if (!old && !large) break;
    gone.push_back({job.id, old});
    bytes -= job.bytes;
  }
  return gone;
}

}  // namespace tiltfeed::daemon
