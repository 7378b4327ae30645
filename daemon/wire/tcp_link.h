#pragma once
// A byte link over TCP: controllers of the Grbl family with a network board.

#include <memory>
#include <string>

#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// Connects within 5 s. Errors: kLink with the address, the system's reason and what to do.
Result<std::unique_ptr<Link>> open_tcp_link(const LinkSpec& link);

}  // namespace tiltfeed::daemon
