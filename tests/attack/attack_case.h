#pragma once
// One case of the random attack, from its seed to its verdict.

#include <cstdint>
#include <string>
#include <vector>

#include "tests/attack/judge.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;

struct CaseFiles {
  std::string folder;               ///< where SEED.yaml, SEED.stl and wide.yaml are written
  std::vector<std::string> models;  ///< STL files to choose from besides the formula parts
};

struct CaseResult {
  std::string story;    ///< the part, and what was done to it
  std::string refusal;  ///< of a case that planning refuses: its message
  Verdict verdict;
  double plan_seconds = 0.0, judge_seconds = 0.0;  ///< processor time
  std::size_t facets = 0, moves = 0;
  std::size_t damaged = 0, damaged_refused = 0;  ///< moves that the proof was tried on
};

/// Makes the folder, if it is not there, and the machine in it that all cases are for. Throws where it
/// cannot.
void prepare(const std::string& folder);

/// Requires: the folder is prepared. Writes the case's files, plans the job as `tiltfeed plan` does and
/// judges what the machine makes of it.
CaseResult run_case(std::uint64_t seed, const CaseFiles& files);
/// The same for files that are there already.
CaseResult run_job(const std::string& job_path);

}  // namespace tiltfeed::attack
