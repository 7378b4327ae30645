#include "daemon/service/notify.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace tiltfeed {

namespace {

constexpr const char* kJournalSocket = "/run/systemd/journal/socket";

bool send_datagram(const char* path, const std::string& bytes) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t size = std::strlen(path);
  if (size == 0 || size >= sizeof address.sun_path) return false;
  std::memcpy(address.sun_path, path, size);
  if (path[0] == '@') address.sun_path[0] = '\0';  // the abstract namespace
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + size);
  const bool sent =
      ::sendto(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address),
               length) == static_cast<ssize_t>(bytes.size());
  ::close(fd);
  return sent;
}

std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) out += static_cast<unsigned char>(c) < ' ' || c == 0x7F ? '?' : c;
  return out;
}

}  // namespace

bool notify(const std::string& state) {
  const char* path = std::getenv("NOTIFY_SOCKET");
  return path != nullptr && send_datagram(path, state);
}

std::uint64_t watchdog_us() {
  const char* text = std::getenv("WATCHDOG_USEC");
  std::uint64_t value = 0;
  if (text != nullptr) std::from_chars(text, text + std::strlen(text), value);
  return value;
}

std::string journal_datagram(Severity severity, const std::string& message, const LogFields& fields) {
  std::string out = "MESSAGE=" + printable(message) +
                    "\nPRIORITY=" + std::to_string(static_cast<int>(severity)) +
                    "\nSYSLOG_IDENTIFIER=tiltfeed\n";
  if (!fields.machine.empty()) out += "TILTFEED_MACHINE=" + printable(fields.machine) + "\n";
  if (fields.job != 0) out += "TILTFEED_JOB=" + std::to_string(fields.job) + "\n";
  if (fields.block != 0) out += "TILTFEED_BLOCK=" + std::to_string(fields.block) + "\n";
  if (fields.by_user) out += "TILTFEED_USER=" + std::to_string(fields.user) + "\n";
  return out;
}

void write_log(Severity severity, const std::string& message, const LogFields& fields) {
  if (std::getenv("JOURNAL_STREAM") != nullptr &&
      send_datagram(kJournalSocket, journal_datagram(severity, message, fields)))
    return;
  std::string line = fields.machine.empty() ? "" : printable(fields.machine) + ": ";
  if (fields.job != 0) line += "job " + std::to_string(fields.job) + ": ";
  if (fields.by_user) line += "user " + std::to_string(fields.user) + ": ";
  std::fprintf(stderr, "%s%s\n", line.c_str(), printable(message).c_str());
}

}  // namespace tiltfeed
