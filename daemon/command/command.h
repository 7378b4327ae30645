#pragma once
// What all subcommands of tiltfeed share: how they end, and where the service is.

#include <ctime>
#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Exit statuses.
inline constexpr int kExitDone = 0, kExitFailed = 1, kExitWrongUse = 2;

/// What a subcommand shows with --json, on standard output. Requires: one JSON object. Returns kExitDone.
int show_json(const std::string& object);

/// The text that a subcommand has made: with --json as an object that has it, else into the file `out` ("-":
/// standard output). The exit status.
int give_text(const std::string& text, const std::string& out, bool as_json);

/// 2026-01-31T23:59:59Z
std::string utc_text(std::time_t at);

/// What is wrong with the number of an option or a word that must be above 0; empty: nothing.
std::string above_zero(const std::string& number);

/// Writes the error to standard error; the exit status that goes with it.
int complain(const Error& error);

/// A job file with its tool written out, as a descriptor of a file without a name: a service does not see the
/// library. -1 where it cannot be had.
int open_written_out(const std::string& job);

inline constexpr const char* kDefaultSocket = "/run/tiltfeed/api.sock";
/// $TILTFEED_SOCKET, else kDefaultSocket.
std::string service_socket();

}  // namespace tiltfeed::daemon
