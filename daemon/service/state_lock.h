#pragma once
// One service a spool, and one a machine: what is taken before anything is read or changed.

#include <map>
#include <string>
#include <vector>

#include "daemon/wire/link.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// FOLDER and its file `lock`, held until it goes out of scope or the process dies, however it dies.
class StateLock {
 public:
  /// Changes nothing in the folder where somebody else holds it. Requires: the folder is there. Errors: kIo;
  /// kUsage with the process that holds it.
  static Result<StateLock> take(const std::string& folder);
  StateLock(StateLock&& other) noexcept
      : folder_(std::exchange(other.folder_, -1)), file_(std::exchange(other.file_, -1)) {}
  StateLock& operator=(StateLock&&) = delete;
  ~StateLock();

 private:
  StateLock() = default;
  int folder_ = -1, file_ = -1;
};

/// What a link leads to, the same for all of its names: a device by its number, not by the links that lead to
/// it; a host by its addresses, all of this computer's own being one. Where nothing is known of it, its name.
std::vector<std::string> machine_keys(const LinkSpec& link);

/// One service a machine, on this computer. The kernel keeps the claim, and takes it back from a dead
/// process.
class MachineClaim {
 public:
  MachineClaim() = default;
  MachineClaim(MachineClaim&&) noexcept = default;
  MachineClaim& operator=(MachineClaim&&) = delete;
  ~MachineClaim();

  /// What this link leads to now, in place of what was claimed before. Errors: kUsage with the process that
  /// has it, kIo; then the claim stays as it was.
  Result<void> follow(const LinkSpec& link);
  /// Takes no notice of who asked who has it; call now and then.
  void turn_away() const;

 private:
  std::map<std::string, int> held_;  // key, listening socket
};

}  // namespace tiltfeed::daemon
