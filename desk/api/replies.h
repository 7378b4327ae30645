#pragma once
// JSON as replies, and what bodies say.

#include <optional>
#include <string>

#include "desk/http/http_message.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// JSON, with a line end.
Reply text_reply(std::string body, int status = 200);
/// The text at `key` of a body that is one JSON object; nothing where it is anything else.
std::optional<std::string> text_in(const std::string& body, const char* key);
/// What the desk's state does not allow is 409, what is wrong in the request 400, what this computer cannot
/// do 507.
Reply refused_by(const Error& error);

/// The name of a file for people to read, never a path; `otherwise` where nothing is left of it.
std::string shown_name(std::string name, const char* otherwise);

}  // namespace tiltfeed::desk
