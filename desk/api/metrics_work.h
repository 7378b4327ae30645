#pragma once
// GET /metrics: what `tiltfeed metrics` says of the service beside the desk, by a process of its own for each
// time that it is asked.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

struct MetricsOptions {
  std::string config;    ///< the service's file; empty: this desk knows none
  std::string tiltfeed;  ///< the program
};

/// Properties: one process at a time; who asks while it works gets the answer of the next one, so that none
/// is older than its question.
class MetricsWork {
 public:
  MetricsWork(MetricsOptions options, std::function<void(std::uint64_t, const Reply&)> finish);

  /// A reply that comes later, text/plain; version=0.0.4. 409: no service's file is known; 503: too many ask,
  /// or the process has failed.
  Reply ask(std::uint64_t ticket);
  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();

 private:
  void begin();
  MetricsOptions options_;
  std::function<void(std::uint64_t, const Reply&)> finish_;
  std::optional<ChildProcess> child_;
  std::vector<std::uint64_t> asked_, waiting_;  ///< of the process that works; of the next one
};

}  // namespace tiltfeed::desk
