#pragma once
// What the files of users and of tokens share: one name a line, NAME:ROLE:SECRET, kept from others' eyes.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// 1 to 32 of [A-Za-z0-9._-].
bool is_user_name(const std::string& name);

struct NameLine {
  std::string name, role, secret;
  std::string at;  ///< path:line: for messages

  tl::unexpected<Error> wrong(const std::string& what) const { return fail(Code::kInput, at + what); }
};

/// Lines that are empty or begin with # count for nothing; no name stands twice. `expected`: the form of a
/// line, for messages. Errors: kInput as path:line: message.
Result<std::vector<NameLine>> parse_names(const std::string& text, const std::string& path,
                                          const char* expected);

/// Errors: kInput: everybody may write the file; kIo.
Result<std::string> read_names(const std::string& path);
/// The file appears whole or not at all, for its owner and group alone. Errors: kIo.
Result<void> save_names(const std::string& path, const std::string& text);

}  // namespace tiltfeed::desk
