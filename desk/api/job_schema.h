#pragma once
// The keys of a job's text for its forms, as JSON.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// A list of what the reader asks for in this text, in its order; desk/API.md has the fields. Errors: kInput:
/// the text is no YAML.
Result<std::string> job_schema(const std::string& text);

}  // namespace tiltfeed::desk
