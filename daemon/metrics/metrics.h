#pragma once
// What a monitoring system is told of a service, in the text format of Prometheus 0.0.4.

#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Room of the file system that the spool is on.
struct SpoolRoom {
  std::uint64_t free_bytes = 0, size_bytes = 0;
};

/// `answers`: the replies of the service to `list`, page by page; none: no service answers, and nothing is
/// said of jobs. Properties: units are seconds, bytes, blocks and ratios; each family has HELP and TYPE once;
/// no sample comes twice; no label has a job's number or name; figures of the run are there while there is
/// one. Errors: kIo: an answer that is not understood.
Result<std::string> metrics_text(const std::vector<std::string>& answers, const std::string& version,
                                 const SpoolRoom& room);

/// Asks the service. An empty list where none answers, or one that hangs does not within 10 s.
std::vector<std::string> all_answers(const std::string& socket);

}  // namespace tiltfeed::daemon
