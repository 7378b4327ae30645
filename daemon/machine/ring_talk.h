#pragma once
// A conversation with a ring controller that no run of this process is on: its status, and mailbox commands
// that are repeated until their number comes back.

#include <optional>
#include <vector>

#include "daemon/wire/link.h"
#include "daemon/wire/modbus_map.h"

namespace tiltfeed::daemon {

class RingTalk {
 public:
  RingTalk(const config::RingMap& map, Link& wire) : map_(map), wire_(wire) {}

  /// Reads the status. Errors: kLink where none that can be used comes.
  Result<void> look();
  /// Of the newest look.
  const RingStatus& status() const { return status_; }
  /// One command, with the number after the newest that was acknowledged. False where it was refused or never
  /// was acknowledged. Requires: look().
  bool tell(MailboxCode code, std::uint32_t argument = 0);
  /// Looks until the machine does not run. False where it goes on.
  bool stands();

 private:
  Result<std::optional<std::vector<std::uint16_t>>> exchange(const ModbusRequest& request);
  void rest();

  const config::RingMap& map_;
  Link& wire_;
  RingStatus status_;
};

}  // namespace tiltfeed::daemon
