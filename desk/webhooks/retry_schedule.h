#pragma once
// When a delivery that failed is tried again, and when it is not.

#include <chrono>
#include <cstdint>
#include <optional>

namespace tiltfeed::desk {

enum class Verdict : std::uint8_t {
  kTaken,    ///< 2xx
  kAgain,    ///< no answer, 408, 429, 5xx: the receiver may take it later
  kRefused,  ///< any other answer, a redirect too: the same request would be refused again
};

/// `status`: of the answer; 0: there was none.
Verdict verdict_of(int status);

constexpr std::chrono::milliseconds kFirstPause{4000}, kLongestPause{600'000}, kLongestWish{3'600'000};
/// A delivery is given up so long after it was put in line. s.
constexpr std::int64_t kGiveUpSeconds = 3 * 24 * 3600;

/// The pause after `tries` (from 1) in vain: between half and all of kFirstPause, doubled with each further
/// try up to kLongestPause. `chance`: 0 to 1, another one each time, so that senders do not come together.
/// `wish`: the receiver's Retry-After, s: no shorter than that, of which kLongestWish counts.
std::chrono::milliseconds pause_after(int tries, double chance, std::optional<std::int64_t> wish);

}  // namespace tiltfeed::desk
