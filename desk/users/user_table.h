#pragma once
// The users' file: one user a line, NAME:ROLE:HASH.

#include <string>
#include <vector>

#include "desk/users/name_table.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

struct User {
  std::string name;
  bool operates = false;  ///< else watches only
  std::string hash;       ///< as crypt(5) has it
};

/// Lines that are empty or begin with # count for nothing. Errors: kInput as path:line: message; `path` is
/// for messages.
Result<std::vector<User>> parse_users(const std::string& text, const std::string& path);
std::string write_users(const std::vector<User>& users);

/// Errors: as parse_users; kIo.
Result<std::vector<User>> load_users(const std::string& path);
/// As save_names().
Result<void> save_users(const std::string& path, const std::vector<User>& users);

}  // namespace tiltfeed::desk
