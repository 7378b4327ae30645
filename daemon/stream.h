#pragma once
// Sends a program to a controller: the one place that owns the wire, the clock and the loop.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "daemon/link.h"
#include "daemon/program.h"
#include "daemon/session.h"
#include "kinematics/result.h"

namespace tiltfeed {

/// Called at most about ten times a second and once at the end. Return false to stop: the machine is put into
/// feed hold and send_program fails with what may have run.
using SendProgress = std::function<bool(const SendState&)>;

struct SendReport {
  LinkKind link = LinkKind::kGrbl;
  std::string header;                     ///< the program's (TILTFEED ...) comment, may be empty
  std::uint64_t lines = 0;                ///< blocks sent (Modbus: motion, dwell and M blocks)
  std::uint64_t bytes = 0;                ///< taken by the wire, real-time bytes and resends included
  std::uint64_t acknowledged = 0;         ///< blocks that the controller has taken over
  std::optional<std::uint64_t> executed;  ///< blocks proved to be executed; all of them on success
  double seconds = 0.0;
  std::uint64_t resends = 0;  ///< identical requests sent again (Modbus only)
};

/// Checks the whole program first and sends nothing when it finds anything wrong; then streams it and returns
/// when the controller has proved that the last block is executed.
/// Errors: kIo, kInput (program, with file:line and text), kLimit (line too long, number out of range), kLink
/// (wire or controller, with the blocks that may have run). An empty `progress` is allowed.
Result<SendReport> send_program(const std::string& program_path, const LinkSpec& link,
                                const SendProgress& progress);

/// The same over a wire and a clock that are given. `session_id` (not 0) names the run on Modbus.
Result<SendReport> send_over(const std::string& program_path, const LinkSpec& spec, Link& link, Clock& clock,
                             std::uint16_t session_id, const SendProgress& progress);

}  // namespace tiltfeed
