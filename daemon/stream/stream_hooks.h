#pragma once
// What is hung into the loop of a run: progress, orders, traffic, records.

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include "daemon/protocol/session.h"
#include "daemon/wire/link.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Called at most about ten times a second, at each change of phase, when every block is executed (before the
/// controller is told that the run is over), and once at the end. Return false to
/// stop.
using SendProgress = std::function<bool(const SendState&)>;

/// The only way in for an operator. Any thread may push; the loop takes within 50 ms, in order.
class CommandQueue {
 public:
  void push(const OperatorCommand& command);
  std::optional<OperatorCommand> take();

 private:
  std::mutex mutex_;
  std::vector<OperatorCommand> waiting_;
};

enum class Way : std::uint8_t { kOut, kIn };

/// What a service hangs into the loop; each may be empty. All are called on the loop's own thread and must
/// not block for longer than a few milliseconds.
struct StreamHooks {
  SendProgress progress = {};
  CommandQueue* commands = nullptr;
  /// Everything that passes the wire, as it passes: bytes (Grbl, RepRap, drip feed) or one packed request or
  /// reply (Modbus, daemon/wire/modbus_map.h). For a black box.
  std::function<void(Way, std::string_view bytes, Time at)> traffic = {};
  /// Write-ahead: called before block `next` (counted from 1, with its line in the file) may reach the wire.
  /// Returns up to which block, >= next, that is on record; it is not called again before that one. An error
  /// stops the machine and ends the run with that error.
  std::function<Result<std::uint64_t>(std::uint64_t next, std::uint64_t line)> reserve = {};
};

}  // namespace tiltfeed::daemon
