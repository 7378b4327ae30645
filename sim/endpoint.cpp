#include "sim/endpoint.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "sim/pty.h"

namespace tiltfeed::sim {
namespace {

// What the host does not read within this many bytes is lost, as on a wire that nobody listens to.
constexpr std::size_t kMostUnread = 1 << 20;
// Silence after the program's end that counts as "the host is done", s.
constexpr double kQuietEnd = 1.0;
constexpr std::size_t kReadBytes = 65536;

/// Writes what the terminal takes; true when something was written.
bool drain(int fd, std::string& unsent) {
  if (unsent.empty()) return false;
  const ssize_t written = write(fd, unsent.data(), unsent.size());
  if (written > 0) unsent.erase(0, static_cast<std::size_t>(written));
  return written > 0;
}

}  // namespace

Result<void> serve_pty(GrblController& controller, const std::string& path, EndpointOptions options) {
  Result<Pty> pty = Pty::open(path);
  if (!pty) return tl::unexpected<Error>(std::move(pty.error()));
  const int fd = pty->master();
  fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
  options.ready(path + " (" + pty->device() + ")");

  Pace pace(options.speed);
  std::array<char, kReadBytes> bytes{};
  std::string unsent;
  double last_traffic = 0.0;
  while (true) {
    std::array<pollfd, 2> fds{{{fd, POLLIN, 0}, {options.stop_fd, POLLIN, 0}}};
    if (!unsent.empty()) fds[0].events |= POLLOUT;
    const double wait = pace.wait(controller);
    const timespec timeout{0, static_cast<long>(wait * 1e9)};
    if (ppoll(fds.data(), fds.size(), &timeout, nullptr) < 0 && errno != EINTR)
      return fail(Code::kIo, path + ": " + std::strerror(errno));
    if (fds[1].revents != 0) break;

    pace.follow(controller);
    const ssize_t count = (fds[0].revents & POLLIN) != 0 ? read(fd, bytes.data(), bytes.size()) : 0;
    if (count > 0) {
      controller.receive({bytes.data(), static_cast<std::size_t>(count)});
    } else {
      pace.jump(controller);
    }
    if (controller.has_output()) unsent += controller.take_output();
    if (unsent.size() > kMostUnread) unsent.clear();
    const bool sent = drain(fd, unsent);
    if (count > 0 || sent || controller.next_event()) last_traffic = pace.real();
    if (pace.time_to_flush()) options.flush();
    if (options.once && controller.program_ended() && pace.real() - last_traffic >= kQuietEnd) break;
  }
  options.flush();
  return {};
}

}  // namespace tiltfeed::sim
