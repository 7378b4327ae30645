#pragma once
// Without TCP the tool's length is baked into a program's words; its header says which.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The lengths, mm, that the program's TILTFEED comments say are in the words, one a tool. Errors: kIo.
Result<std::vector<double>> baked_lengths(const std::string& path);

/// Nothing to say where the program has a tool of this length (within the printed 0.0001 mm) or says nothing
/// of one. Errors: kInput with both lengths and what to do; kIo.
Result<void> check_tool_length(const std::string& path, double length);

}  // namespace tiltfeed::daemon
