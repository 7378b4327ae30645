#pragma once
// `tiltfeed send`: a program to the controller, with the operator's keys where there is a terminal.

#include <string>

namespace tiltfeed::daemon {

/// Returns the exit status: 0 done, 1 failed, 2 wrong use. `link_text` empty: the machine profile's default;
/// `machine` empty: no profile. SIGINT, SIGTERM, SIGHUP, SIGPIPE and a terminal that goes hold the machine
/// and stop the run.
int send_command(const std::string& program, std::string link_text, const std::string& machine, bool as_json);

}  // namespace tiltfeed::daemon
