#pragma once
// Files that are made at once.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

/// Makes or replaces a file. Errors: kIo.
Result<void> write_bytes(const std::string& path, const std::string& bytes);

}  // namespace tiltfeed::sim
