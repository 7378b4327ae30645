#pragma once
// `tiltfeed-sim check-path`: a program or an executed trace against the planned path and the part.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

/// Paths; empty: not given.
struct PathCheckFiles {
  std::string job, cl;
  std::string program, canon;  ///< one of them
  std::string trace;           ///< empty: what the simulated axes make of the program
  std::string report;          ///< of the planner: facets that it could not reach are marked in the picture
  std::string picture, json;   ///< written
};

/// Prints the report; true when the job was done right. Errors: of the files; kUsage.
Result<bool> path_check_command(const PathCheckFiles& files);

}  // namespace tiltfeed::sim
