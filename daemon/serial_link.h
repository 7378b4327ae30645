#pragma once
// A byte link over a serial port (libserialport) or a pseudo-terminal (raw termios).

#include <memory>
#include <string>

#include "daemon/link.h"

namespace tiltfeed {

/// 8N1, no flow control, exclusive, not blocking. Symbolic links (/dev/serial/by-id/...) are followed first.
/// Errors: kLink with the device, the system's reason and what to do; busy when somebody else has it.
Result<std::unique_ptr<Link>> open_serial_link(const std::string& device, int baud);

}  // namespace tiltfeed
