#pragma once
// The keys of a job's text for its forms, as JSON.

#include <cstddef>
#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// What the reader asks for in this text, in its order; desk/API.md has the fields. `operation`: of this one,
/// counted from 1 in the list; 0: of what the job says for all. Errors: kInput: the text is no YAML; kUsage:
/// there is no such operation.
Result<std::string> job_schema(const std::string& text, std::size_t operation);

}  // namespace tiltfeed::desk
