#pragma once
// The clock that runs go by: it never jumps.

#include <chrono>

#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

class SteadyClock : public Clock {
 public:
  Time now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
};

}  // namespace tiltfeed::daemon
