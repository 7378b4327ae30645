#pragma once
// `tiltfeed desk token add|remove|list`: the file of programs' tokens.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// A new token, which is kept nowhere but as its digest. `scope`: watch or submit. A program that is there
/// gets a new token and scope. Errors: kUsage, kInput, kIo.
Result<std::string> add_token(const std::string& file, const std::string& name, const std::string& scope);
Result<void> remove_token(const std::string& file, const std::string& name);
/// "NAME SCOPE" a line.
Result<std::string> list_tokens(const std::string& file);

}  // namespace tiltfeed::desk
