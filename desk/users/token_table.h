#pragma once
// Tokens of programs that use the API, such as the post of a CAM system: one a line, NAME:SCOPE:DIGEST.

#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

struct ProgramToken {
  std::string name;
  bool submits = false;  ///< else watches only
  std::string digest;    ///< SHA-256 of the token, 64 lower-case hexadecimal digits
};

/// A token has 256 bits of the kernel's randomness: a plain digest keeps it, no guess finds it.
std::string digest_of(const std::string& token);

/// Lines that are empty or begin with # count for nothing. Errors: kInput as path:line: message; `path` is
/// for messages.
Result<std::vector<ProgramToken>> parse_tokens(const std::string& text, const std::string& path);
std::string write_tokens(const std::vector<ProgramToken>& tokens);

/// Errors: as parse_tokens; kIo.
Result<std::vector<ProgramToken>> load_tokens(const std::string& path);
/// As save_users().
Result<void> save_tokens(const std::string& path, const std::vector<ProgramToken>& tokens);

/// Whose token it is, compared in a time that tells nothing.
std::optional<ProgramToken> find_token(const std::vector<ProgramToken>& tokens, const std::string& token);

}  // namespace tiltfeed::desk
