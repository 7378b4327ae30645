#include "daemon/command/held_keys.h"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>

namespace tiltfeed::daemon {

struct HeldKeys::Terminal {
  termios before{};
  bool changed = false;

  Terminal() {
    if (::isatty(STDIN_FILENO) != 1 || ::tcgetattr(STDIN_FILENO, &before) != 0) return;
    termios raw = before;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    changed = ::tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
  }
  ~Terminal() {
    if (changed) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
};

HeldKeys::HeldKeys() : terminal_(std::make_unique<Terminal>()) {}
HeldKeys::~HeldKeys() = default;

bool HeldKeys::held() {
  const auto now = std::chrono::steady_clock::now();
  while (!over_) {
    pollfd typed{STDIN_FILENO, POLLIN, 0};
    if (::poll(&typed, 1, 0) <= 0) break;
    char keys[256];
    const ssize_t size = ::read(STDIN_FILENO, keys, sizeof keys);
    if (size > 0) heard_ = now;
    if (size == 0 || (size < 0 && errno != EINTR && errno != EAGAIN)) over_ = true;
    if (size < 0) break;
  }
  over_ = over_ || now - heard_ > kPatience;
  return !over_;
}

}  // namespace tiltfeed::daemon
