#pragma once
// A byte link through a WebSocket, as the network boards of grblHAL and FluidNC offer it.

#include <memory>

#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// Connects, and opens the WebSocket within 5 s. Requires: link.carrier == Carrier::kWebSocket. Errors: kLink
/// with the reason and what to check.
Result<std::unique_ptr<Link>> open_websocket_link(const LinkSpec& link);

}  // namespace tiltfeed::daemon
