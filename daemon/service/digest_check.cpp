#include "daemon/service/digest_check.h"

#include <cassert>
#include <chrono>

namespace tiltfeed::daemon {

void DigestCheck::start(const std::string& program, const LinkSpec& link, std::uint64_t job) {
  assert(!busy());
  job_ = job;
  result_ = std::async(std::launch::async, prepare_run, program, link, job);
}

std::optional<Result<ProgramRun>> DigestCheck::take() {
  if (!busy() || result_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
  return result_.get();
}

}  // namespace tiltfeed::daemon
