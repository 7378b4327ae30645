#pragma once
// `tiltfeed desk user add|remove|list`: the users' file.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// `role`: watch or operate. The password is typed twice without echo, or is the first line of what is no
/// terminal. A user that is there gets the new password and role. Errors: kUsage, kInput, kIo.
Result<void> add_user(const std::string& file, const std::string& name, const std::string& role);
Result<void> remove_user(const std::string& file, const std::string& name);
/// "NAME ROLE" a line.
Result<std::string> list_users(const std::string& file);

}  // namespace tiltfeed::desk
