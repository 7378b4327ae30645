#include "sim/wire/pty.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace tiltfeed::sim {
namespace {

tl::unexpected<Error> io_error(const std::string& what) {
  return fail(Code::kIo, what + ": " + std::strerror(errno));
}

std::string link_target(const std::string& path) {
  std::array<char, 256> target{};
  const ssize_t length = readlink(path.c_str(), target.data(), target.size());
  return length > 0 ? std::string(target.data(), static_cast<std::size_t>(length)) : std::string();
}

}  // namespace

Result<Pty> Pty::open(const std::string& path) {
  struct stat existing {};
  if (lstat(path.c_str(), &existing) == 0 && !S_ISLNK(existing.st_mode))
    return fail(Code::kIo, path + ": exists and is not a symbolic link; choose another name or remove it");

  Pty pty;
  pty.master_ = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (pty.master_ < 0 || grantpt(pty.master_) != 0 || unlockpt(pty.master_) != 0)
    return io_error("no pseudo-terminal");
  std::array<char, 128> name{};
  if (ptsname_r(pty.master_, name.data(), name.size()) != 0) return io_error("no pseudo-terminal");
  pty.device_ = name.data();
  pty.slave_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (pty.slave_ < 0) return io_error(pty.device_);
  struct termios raw {};
  if (tcgetattr(pty.slave_, &raw) != 0) return io_error(pty.device_);
  cfmakeraw(&raw);  // before the name exists: no byte is ever echoed
  cfsetspeed(&raw, B115200);
  if (tcsetattr(pty.slave_, TCSANOW, &raw) != 0) return io_error(pty.device_);

  if (existing.st_mode != 0 && unlink(path.c_str()) != 0) return io_error(path);
  if (symlink(pty.device_.c_str(), path.c_str()) != 0) return io_error(path);
  pty.path_ = path;
  return pty;
}

Pty::~Pty() {
  if (!path_.empty() && link_target(path_) == device_) unlink(path_.c_str());
  if (slave_ >= 0) close(slave_);
  if (master_ >= 0) close(master_);
}

}  // namespace tiltfeed::sim
