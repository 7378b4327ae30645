#pragma once
// Secrets: made, and compared.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// 256 bits of the kernel's randomness as 64 hexadecimal digits. Errors: kIo.
Result<std::string> random_secret();

/// Whether two texts are the same, in a time that tells nothing of where they differ.
bool same_secret(const std::string& a, const std::string& b);

}  // namespace tiltfeed::desk
