#pragma once
// A message link over Modbus TCP or RTU (libmodbus).

#include <memory>

#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// After every missing or damaged reply the wire is made clean before the next request: RTU is left silent
/// for longer than the longest reply and flushed, TCP is closed and connected anew; so a late reply can never
/// be taken for the next one. Requires: a link of the ring or of a drive. Errors: kLink with the address
/// or device and the reason.
Result<std::unique_ptr<Link>> open_modbus_link(const LinkSpec& link);

}  // namespace tiltfeed::daemon
