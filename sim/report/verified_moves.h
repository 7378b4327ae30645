#pragma once
// The moves that are verified: of a program, a trace or LinuxCNC's canon, by the operations of the job.

#include <string>
#include <vector>

#include "config/job.h"
#include "sim/removal/executed_path.h"
#include "sim/report/program_header.h"
#include "sim/report/verdict.h"

namespace tiltfeed::sim {

/// The one file that says the moves.
struct MovesFile {
  Source kind;
  std::string name;
};

struct VerifiedMoves {
  ProgramHeader header;             ///< of a program
  std::vector<ExecutedPath> paths;  ///< by operation
};

/// Executes a program as it is read, which no memory for all of its blocks is needed for. Errors: kIo, kInput
/// with `name` and line; kUsage: a trace or canon of several operations.
Result<VerifiedMoves> read_moves(const MovesFile& file, const std::vector<config::Job>& operations);

}  // namespace tiltfeed::sim
