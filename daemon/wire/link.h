#pragma once
// The wire and the clock: the only two virtual seams of the program, so that a session can be run against a
// scripted controller in made-up time. Also the LINK text of the command line.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "config/link_profile.h"
#include "daemon/program/link_kind.h"
#include "daemon/program/numeric_block.h"
#include "daemon/wire/position_limits.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// An instant, counted from the clock's own start, or a span of time.
using Time = std::chrono::nanoseconds;
inline Time time_of(double seconds) {
  return std::chrono::duration_cast<Time>(std::chrono::duration<double>(seconds));
}

class Clock {
 public:
  virtual ~Clock() = default;
  virtual Time now() = 0;  ///< never runs backwards
};

/// One wire to one controller. A byte link (Grbl) carries any run of bytes either way. A message link
/// (Modbus) carries whole requests and replies, packed as in daemon/wire/modbus_map.h.
class Link {
 public:
  virtual ~Link() = default;

  /// Hands as much of `out` to the wire as it takes, appends what came to `in`, returns the bytes of `out`
  /// that were taken. Returns as soon as something has come or was taken, at the latest after `wait`.
  /// A byte link may take part of `out` and may bring nothing. A message link takes `out` whole and brings
  /// exactly one reply in the same call (a missing reply is a reply that says so); an empty `out` only waits.
  /// Errors: kLink when the wire is gone for good, with the device and what to do: nothing of `out` was
  /// taken. A loss that is seen after bytes were taken is told by the next call.
  virtual Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) = 0;
};

/// What carries the bytes of a byte link.
enum class Carrier : std::uint8_t { kSerial, kTcp, kWebSocket };

/// Which wire, and the two figures that a controller may not tell by itself.
struct LinkSpec {
  LinkKind kind = LinkKind::kGrbl;
  Carrier carrier = Carrier::kSerial;  ///< of a Grbl controller
  std::string place;                   ///< device file, or host name or address
  int port = 502;                      ///< of TCP
  std::string path = "/";              ///< of a WebSocket
  int baud = 115200;                   ///< of a serial line
  int unit = 1;                        ///< Modbus unit (slave) number
  int receive_buffer = 0;              ///< of a Grbl controller, bytes; 0: ask the controller
  int max_line = 0;                  ///< longest line that a Grbl controller takes, bytes; 0: by its firmware
  config::LinkProfile profile = {};  ///< the rest, from the machine profile; not part of the LINK text
  NumericAxes axes = {};             ///< that the machine has; not part of the LINK text
  PositionLimits positions = {};     ///< where the machine may be reported; not part of the LINK text

  /// Nothing locks it when it is opened, as opening a serial port does.
  bool over_network() const {
    return carrier != Carrier::kSerial || kind == LinkKind::kModbusTcp || kind == LinkKind::kDriveTcp;
  }
};

/// Reads `grbl:/dev/ttyUSB0[@115200]`, `grbl-tcp:HOST:PORT`, `grbl-ws:HOST:PORT[/PATH]`,
/// `reprap:/dev/ttyUSB0[@115200]`, `dnc:/dev/ttyS0[@9600]`, `modbus-tcp:HOST:PORT[/UNIT]` (IPv6 in brackets),
/// `modbus-rtu:/dev/ttyS0[@19200[/UNIT]]`, or the last two with `drive-` for a plain drive. Errors: kUsage
/// with what is wrong and an example of each form. `profile`: what the machine profile says of the wire;
/// `machine`: whose travels no report may leave.
Result<LinkSpec> parse_link(std::string_view text, const config::LinkProfile& profile = {},
                            const MachineModel* machine = nullptr);
/// The LINK text again, with the defaults filled in: parse_link(describe(s)) = s.
std::string describe(const LinkSpec& link);
}  // namespace tiltfeed::daemon
