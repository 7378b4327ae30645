#pragma once

namespace tiltfeed {

/// Of `all` samples those that are taken: a quarter, one at least, under the address sanitizer. There the
/// memory is judged; the answers are judged in Release, by all of them.
constexpr int samples(int all) {
#ifdef TILTFEED_SANITIZED
  return all < 4 ? 1 : all / 4;
#else
  return all;
#endif
}

}  // namespace tiltfeed
