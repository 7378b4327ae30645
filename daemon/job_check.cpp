#include "daemon/job_check.h"

#include <cassert>
#include <chrono>

namespace tiltfeed {

namespace {

constexpr std::chrono::milliseconds kAliveInterval{100};

}  // namespace

void ProgramCheck::start(const std::string& program, const LinkSpec& link, std::uint64_t job) {
  assert(!busy());
  job_ = job;
  result_ = std::async(std::launch::async, prepare_run, program, link, job);
}

std::optional<Result<JobRun>> ProgramCheck::take() {
  if (!busy() || result_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
  return result_.get();
}

Result<JobRun> prepare_alive(const std::string& program, const LinkSpec& link, std::uint64_t job,
                             const std::function<void()>& alive) {
  std::future<Result<JobRun>> result = std::async(std::launch::async, prepare_run, program, link, job);
  while (result.wait_for(kAliveInterval) != std::future_status::ready) alive();
  return result.get();
}

}  // namespace tiltfeed
