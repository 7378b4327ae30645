#include "desk/webhooks/retry_schedule.h"

#include <algorithm>

namespace tiltfeed::desk {

Verdict verdict_of(int status) {
  constexpr int kTimeout = 408, kTooMany = 429;
  if (status >= 200 && status < 300) return Verdict::kTaken;
  if (status < 200 || status >= 500 || status == kTimeout || status == kTooMany) return Verdict::kAgain;
  return Verdict::kRefused;
}

std::chrono::milliseconds pause_after(int tries, double chance, std::optional<std::int64_t> wish) {
  using std::chrono::milliseconds;
  std::int64_t pause = kFirstPause.count();
  for (int i = 1; i < tries && pause < kLongestPause.count(); ++i) pause *= 2;
  pause = std::min<std::int64_t>(pause, kLongestPause.count());
  pause =
      pause / 2 + static_cast<std::int64_t>(std::clamp(chance, 0.0, 1.0) * static_cast<double>(pause / 2));
  if (!wish) return milliseconds(pause);
  constexpr std::int64_t kMilli = 1000;
  const std::int64_t wanted = std::clamp<std::int64_t>(*wish, 0, kLongestWish.count() / kMilli) * kMilli;
  return milliseconds(std::max(pause, wanted));
}

}  // namespace tiltfeed::desk
