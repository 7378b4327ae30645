#pragma once
// The simulated controllers on real links. Each call serves until options.stop_fd or options.once ends it.

#include <string>

#include "kinematics/basics/result.h"
#include "sim/controller/drip_controller.h"
#include "sim/controller/grbl_controller.h"
#include "sim/controller/modbus_controller.h"
#include "sim/controller/reprap_controller.h"
#include "sim/wire/sim_clock.h"

namespace tiltfeed::sim {

/// Silence after the program's end that counts as "the host is done", s.
inline constexpr double kQuietEnd = 1.0;

/// On a pseudo-terminal, with a symbolic link `path` to it. After a disconnect of the fault script it is
/// another terminal under the same link. Errors: kIo.
Result<void> serve_pty(GrblController& controller, const std::string& path, EndpointOptions options);
Result<void> serve_pty(RepRapController& controller, const std::string& path, EndpointOptions options);
Result<void> serve_pty(DripController& controller, const std::string& path, EndpointOptions options);

/// On TCP, as a controller with a network board: "ADDRESS:PORT", port 0 takes a free one. A host is greeted
/// with the banner when it connects; the machine goes on when it has gone. Errors: kUsage, kIo.
Result<void> serve_tcp(GrblController& controller, const std::string& place, EndpointOptions options);

/// The same through a WebSocket.
Result<void> serve_ws(GrblController& controller, const std::string& place, EndpointOptions options);

/// Modbus TCP server on a numeric IPv4 address; port 0 takes a free one, `ready` tells which. One client at
/// a time; it may come and go. Errors: kUsage, kIo.
Result<void> serve_modbus_tcp(ModbusController& controller, const std::string& address, int port,
                              EndpointOptions options);

/// Modbus RTU, unit 1, on a pseudo-terminal with a symbolic link `path` to it. Errors: kIo.
Result<void> serve_modbus_rtu(ModbusController& controller, const std::string& path, EndpointOptions options);

}  // namespace tiltfeed::sim
