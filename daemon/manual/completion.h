#pragma once
// Scripts that complete a command line in a shell, from its description.

#include <string>

#include "config/command_line.h"

namespace tiltfeed::daemon {

std::string bash_completion(const config::Command& program);
std::string zsh_completion(const config::Command& program);
std::string fish_completion(const config::Command& program);

}  // namespace tiltfeed::daemon
