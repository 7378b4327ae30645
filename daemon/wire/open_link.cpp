#include "daemon/wire/open_link.h"

#include "daemon/wire/modbus_link.h"
#include "daemon/wire/serial_link.h"
#include "daemon/wire/tcp_link.h"
#include "daemon/wire/websocket_link.h"

namespace tiltfeed::daemon {

Result<std::unique_ptr<Link>> open_link(const LinkSpec& link) {
  switch (link.kind) {
    case LinkKind::kGrbl:
      if (link.carrier == Carrier::kWebSocket) return open_websocket_link(link);
      if (link.carrier == Carrier::kTcp) return open_tcp_link(link);
      return open_serial_link(link.place, {link.baud});
    case LinkKind::kRepRap:
      return open_serial_link(link.place, {link.baud});
    case LinkKind::kDrip: {
      const config::DripFormat& drip = link.profile.drip;
      return open_serial_link(link.place, {link.baud, drip.data_bits, drip.parity, drip.stop_bits,
                                           drip.flow == config::FlowControl::kRtsCts});
    }
    case LinkKind::kModbusTcp:
    case LinkKind::kModbusRtu:
    case LinkKind::kDriveTcp:
    case LinkKind::kDriveRtu:
      break;
  }
  return open_modbus_link(link);
}

}  // namespace tiltfeed::daemon
