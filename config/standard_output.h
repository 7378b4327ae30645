#pragma once
// The standard streams of a command.

namespace tiltfeed::config {

/// Before a command opens anything: a standard stream that is closed is taken by nothing else. A pipe whose
/// reader has gone and a file that may not grow further (ulimit -f) are errors and no signals.
void open_standard_streams();
/// At a command's end: what it printed has arrived. If not, says so as `program` on standard error and makes
/// a status of 0 a 1.
int close_standard_output(const char* program, int status);

}  // namespace tiltfeed::config
