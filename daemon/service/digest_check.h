#pragma once
// Programs are read whole before they may run: hash, every line, number of blocks. Long ones take seconds, so
// that is done beside the service's loop, which goes on answering, and being watched.

#include <cstdint>
#include <future>
#include <optional>
#include <string>

#include "daemon/journal/program_run.h"

namespace tiltfeed::daemon {

/// One check at a time.
class DigestCheck {
 public:
  bool busy() const { return result_.valid(); }
  std::uint64_t job() const { return job_; }
  /// Requires: not busy.
  void start(const std::string& program, const LinkSpec& link, std::uint64_t job);
  /// The outcome, once.
  std::optional<Result<ProgramRun>> take();

 private:
  std::uint64_t job_ = 0;
  std::future<Result<ProgramRun>> result_;
};

}  // namespace tiltfeed::daemon
