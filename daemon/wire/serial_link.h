#pragma once
// A byte link over a serial port (libserialport) or a pseudo-terminal (raw termios).

#include <memory>
#include <string>

#include "config/link_profile.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// XON/XOFF is left to the session: the driver would swallow the bytes that it must see.
struct SerialFormat {
  int baud = 115200;
  int data_bits = 8;
  config::Parity parity = config::Parity::kNone;
  int stop_bits = 1;
  bool rts_cts = false;
};

/// Exclusive, not blocking. Symbolic links (/dev/serial/by-id/...) are followed first.
/// Errors: kLink with the device, the system's reason and what to do; busy when somebody else has it.
Result<std::unique_ptr<Link>> open_serial_link(const std::string& device, const SerialFormat& format);

}  // namespace tiltfeed::daemon
