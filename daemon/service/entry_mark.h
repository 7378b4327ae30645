#pragma once
// What a job that enters another one again keeps of that one.

#include <cstdint>
#include <optional>
#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct EntryMark {
  std::uint64_t job = 0;    ///< that is entered
  std::uint64_t from = 0;   ///< its block that is the first to run again
  std::uint64_t total = 0;  ///< its blocks
};

/// Writes it to `file`. Errors: kIo.
Result<void> write_entry_mark(const std::string& file, const EntryMark& mark);
/// Nothing where `file` is not there, or none of these: the job enters no other.
std::optional<EntryMark> read_entry_mark(const std::string& file);

/// "of job 3 that is blocks 120 to 135": in numbers of the entered job, what may have run of the job that
/// enters it, after `executed` and up to `may_have` of its `total` blocks. The last of those are the entered
/// job's.
std::string entered_range(const EntryMark& mark, std::uint64_t executed, std::uint64_t may_have,
                          std::uint64_t total);

}  // namespace tiltfeed::daemon
