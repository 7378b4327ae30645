#include "daemon/service/notify.h"

#define SD_JOURNAL_SUPPRESS_LOCATION  // a line is about the machine, not about the source
#include <sys/uio.h>
#include <systemd/sd-daemon.h>
#include <systemd/sd-journal.h>

#include <cstdio>
#include <cstdlib>

namespace tiltfeed::daemon {

namespace {

std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) out += static_cast<unsigned char>(c) < ' ' || c == 0x7F ? '?' : c;
  return out;
}

bool sent_to_journal(std::vector<std::string> fields) {
  std::vector<iovec> pieces;
  for (std::string& one : fields) pieces.push_back({one.data(), one.size()});
  return ::sd_journal_sendv(pieces.data(), static_cast<int>(pieces.size())) == 0;
}

}  // namespace

bool notify(const std::string& state) { return ::sd_notify(0, state.c_str()) > 0; }

std::uint64_t watchdog_us() {
  std::uint64_t value = 0;
  return ::sd_watchdog_enabled(0, &value) > 0 ? value : 0;
}

std::vector<std::string> journal_fields(Severity severity, const std::string& message,
                                        const LogFields& fields) {
  std::vector<std::string> out{"MESSAGE=" + printable(message),
                               "PRIORITY=" + std::to_string(static_cast<int>(severity)),
                               "SYSLOG_IDENTIFIER=tiltfeed"};
  if (!fields.machine.empty()) out.push_back("TILTFEED_MACHINE=" + printable(fields.machine));
  if (fields.job != 0) out.push_back("TILTFEED_JOB=" + std::to_string(fields.job));
  if (fields.block != 0) out.push_back("TILTFEED_BLOCK=" + std::to_string(fields.block));
  if (fields.by_user) out.push_back("TILTFEED_USER=" + std::to_string(fields.user));
  return out;
}

void write_log(Severity severity, const std::string& message, const LogFields& fields) {
  if (std::getenv("JOURNAL_STREAM") != nullptr && sent_to_journal(journal_fields(severity, message, fields)))
    return;
  std::string line = fields.machine.empty() ? "" : printable(fields.machine) + ": ";
  if (fields.job != 0) line += "job " + std::to_string(fields.job) + ": ";
  if (fields.by_user) line += "user " + std::to_string(fields.user) + ": ";
  std::fprintf(stderr, "%s%s\n", line.c_str(), printable(message).c_str());
}

}  // namespace tiltfeed::daemon
