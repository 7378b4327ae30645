#pragma once
// G-code blocks: joint path -> program text in the machine's dialect.

#include <cstdint>
#include <iosfwd>
#include <string>

#include "config/job.h"
#include "kinematics/joint_path.h"
#include "kinematics/result.h"

namespace tiltfeed {

struct ProgramReport {
  std::uint64_t blocks = 0;         ///< motion blocks written
  std::uint64_t clamped_feeds = 0;  ///< G93 F limited to the control's range
  std::uint64_t bytes = 0;
};

/// Largest relative error of a printed F.
inline constexpr double kFeedError = 1e-4;

/// Writes the program: header comments (TILTFEED ...: part, machine, tool, tool length that is baked in,
/// blocks, time), safe start words, G93 blocks with all axes that changed (all five in the first, a rapid), F
/// = 1/T (1/min) on every feed block, G94, M5, M2. ASCII, LF, at most the profile's decimals, never "-0" or
/// an exponent. The same bytes on any number of threads. After an error `out` holds a part of it: write into
/// an OutputFile, which then leaves nothing. Requires: `path` rounded to the profile's decimals. Errors:
/// kLimit when a line is longer than the control takes; kInput when there is no block; kIo; kCancelled.
Result<ProgramReport> write_program(const JointPath& path, const Job& job, std::ostream& out,
                                    const StageProgress& progress = {});

}  // namespace tiltfeed
