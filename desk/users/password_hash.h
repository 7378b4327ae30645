#pragma once
// Passwords as yescrypt hashes, by libxcrypt.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// Lengths that a password may have, bytes.
inline constexpr std::size_t kLeastPassword = 8, kMostPassword = 256;

/// With a salt of its own. Takes some 25 ms and 16 MiB. Errors: kUsage: the password's length; kIo.
Result<std::string> hash_password(const std::string& password);
/// False also where the hash is none.
bool password_matches(const std::string& password, const std::string& hash);

}  // namespace tiltfeed::desk
