#pragma once
// What the commands ask the service, and what they wait for.

#include <string>
#include <vector>

#include "daemon/service/api.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The answer, one JSON object. Errors: those of ask_service; kInput where the service refuses.
Result<std::string> ask_json(const std::string& socket, const ApiRequest& request,
                             const std::vector<int>& files = {});

/// Nothing is left that could change this state by itself.
bool is_over(const std::string& state);

/// The answer to a word that begins a run says so before the controller has been asked. This waits until it
/// has taken the run: the job as `show` has it, with `taken` as its text. Another answer is returned as it
/// is. Requires: of ask_json. Errors: kLink (the run came to nothing: why); those of ask_json.
Result<std::string> until_taken(const std::string& socket, const std::string& answer,
                                const std::string& taken);

}  // namespace tiltfeed::daemon
