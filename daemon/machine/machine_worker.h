#pragma once
// One machine command at a time beside the loop that answers, over a wire of its own.

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/machine/machine_orders.h"

namespace tiltfeed::daemon {

class MachineWorker {
 public:
  /// A continuous jog that nobody asks for again within this time ends.
  static constexpr std::chrono::milliseconds kPatience{500};

  MachineWorker() = default;
  MachineWorker(const MachineWorker&) = delete;
  MachineWorker& operator=(const MachineWorker&) = delete;
  /// Ends the command that is in work.
  ~MachineWorker();

  bool busy() const { return working_; }
  /// Requires: not busy. `ended` is called on the worker's thread, when nothing of the command moves by it
  /// any more. Returns the command's number, from 1 up.
  std::uint64_t start(const config::MachineProfile& machine, const LinkSpec& link, const std::string& name,
                      const std::vector<std::string>& words, const std::function<void()>& ended = {});
  /// Of the newest command; 0: there was none.
  std::uint64_t number() const { return number_; }
  const std::string& name() const { return name_; }
  /// The operator still holds the key.
  void renew();
  /// Ends the motion of the command that is in work.
  void stop() { stopped_ = true; }
  /// Of the newest command; nothing while it is in work.
  std::optional<Result<MachineAnswer>> end() const;

 private:
  Result<MachineAnswer> work(const config::MachineProfile& machine, const LinkSpec& link,
                             const std::string& name, const std::vector<std::string>& words);

  std::thread thread_;
  std::atomic<bool> working_{false}, stopped_{false};
  std::atomic<std::int64_t> renewed_{0};  ///< steady clock, ns
  std::uint64_t number_ = 0;
  std::string name_;
  mutable std::mutex mutex_;
  std::optional<Result<MachineAnswer>> end_;  // guarded
};

}  // namespace tiltfeed::daemon
