#pragma once
// Without TCP the tool's length is baked into a program's words, and in tilted planes into the way to each of
// them; its header says which.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct BakedLengths {
  std::vector<double> lengths;  ///< mm, one a tool
  bool planes = false;  ///< of a program in tilted planes, which goes over their first places with them
};

/// The lengths that the program's TILTFEED comments say are in the words, or that its tilted planes are
/// planned for. Errors: kIo.
Result<BakedLengths> baked_lengths(const std::string& path);

/// Nothing to say where the program has a tool of this length (within the printed 0.0001 mm) or says nothing
/// of one. Errors: kInput with both lengths and what to do; kIo.
Result<void> check_tool_length(const std::string& path, double length);

}  // namespace tiltfeed::daemon
