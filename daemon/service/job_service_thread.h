#pragma once
// The job service on a thread of its own, so that who answers the socket waits for no disk.

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

/// What is posted is done in order. Replies wait until they are taken; `wake_fd` can be read then.
class JobServiceThread {
 public:
  /// `turned` is called about ten times a second while no run turns.
  JobServiceThread(JobService& jobs, std::function<void()> turned);
  JobServiceThread(const JobServiceThread&) = delete;
  JobServiceThread& operator=(const JobServiceThread&) = delete;
  /// The machine is held or stopped first, 15 s at most.
  ~JobServiceThread();

  void post(std::function<void(JobService&)> task);
  /// Called from any thread.
  void reply(std::uint64_t client, std::string line);
  int wake_fd() const { return wake_; }
  std::vector<std::pair<std::uint64_t, std::string>> take_replies();

 private:
  void run();
  void leave();
  std::vector<std::function<void(JobService&)>> wait_for_tasks();

  JobService& jobs_;
  std::function<void()> turned_;
  int wake_ = -1;
  std::mutex mutex_;  // guards what follows
  std::condition_variable posted_;
  std::vector<std::function<void(JobService&)>> tasks_;
  std::vector<std::pair<std::uint64_t, std::string>> replies_;
  bool leaving_ = false;
  std::thread thread_;  // last: it uses all of that
};

}  // namespace tiltfeed::daemon
