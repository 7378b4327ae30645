#pragma once
// From a LINK to an open wire.

#include <memory>

#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// Opens the wire. Errors: kLink with the device or address and what to do.
Result<std::unique_ptr<Link>> open_link(const LinkSpec& link);

}  // namespace tiltfeed::daemon
