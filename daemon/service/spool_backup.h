#pragma once
// A copy of a spool that another service, or the same one after a loss, can begin with.

#include <cstdint>
#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Table and files of all jobs, as of one moment, while a service may be at work; not the journals: what ran
/// after the copy was made is not in them, so that a job which had begun is uncertain over its whole program
/// when the copy is put back. `to` appears whole or not at all. Returns the number of jobs. Errors: kUsage
/// (`to` is there already), kIo.
Result<std::uint64_t> back_up(const std::string& spool, const std::string& to);

}  // namespace tiltfeed::daemon
