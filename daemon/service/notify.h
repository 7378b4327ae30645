#pragma once
// What systemd and its journal are told; without them, nothing and lines on standard error.

#include <cstdint>
#include <string>
#include <vector>

namespace tiltfeed::daemon {

/// To $NOTIFY_SOCKET: "READY=1", "STATUS=...", "WATCHDOG=1", "STOPPING=1". True when it was
/// sent.
bool notify(const std::string& state);
/// Microseconds within which WATCHDOG=1 is due; 0: nobody waits for it.
std::uint64_t watchdog_us();

enum class Severity : std::uint8_t { kError = 3, kWarning = 4, kInfo = 6 };

/// What a line in the log is about; 0 and empty fields are left out.
struct LogFields {
  std::string machine;
  std::uint64_t job = 0, block = 0;
  std::uint32_t user = 0;
  bool by_user = false;  ///< `user` is meant
};
/// To the journal with fields TILTFEED_MACHINE, TILTFEED_JOB, TILTFEED_BLOCK, TILTFEED_USER where standard
/// error goes there, else one line on standard error. Control characters are shown as '?'.
void write_log(Severity severity, const std::string& message, const LogFields& fields);
/// What the journal is told, as FIELD=value. Pure.
std::vector<std::string> journal_fields(Severity severity, const std::string& message,
                                        const LogFields& fields);

}  // namespace tiltfeed::daemon
