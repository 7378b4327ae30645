// libserialport 0.1.1 knows a port only by /sys/class/tty and by its modem lines, so it refuses
// pseudo-terminals and symbolic links. Symbolic links are resolved here; pseudo-terminals are opened with
// termios directly.

#include "daemon/wire/serial_link.h"

#include <fcntl.h>
#include <libserialport.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>

namespace tiltfeed::daemon {

namespace {

constexpr std::size_t kReadSize = 4096;
constexpr std::string_view kPseudoTerminals = "/dev/pts/";

struct FreePort {
  void operator()(sp_port* port) const {
    sp_close(port);
    sp_free_port(port);
  }
};
using Port = std::unique_ptr<sp_port, FreePort>;

/// The reason of the last failed libserialport call.
std::string port_reason(sp_return code) {
  if (code == SP_ERR_ARG) return "not a serial port";
  if (code == SP_ERR_SUPP) return "not supported by the port";
  if (code == SP_ERR_MEM) return "out of memory";
  return std::strerror(sp_last_error_code());
}

tl::unexpected<Error> cannot_open(const std::string& device, const std::string& reason) {
  return fail(Code::kLink, device + ": cannot be opened: " + reason +
                               "; check the name (ls -l /dev/serial/by-id), your group (dialout) and that no "
                               "other program has it");
}

class SerialLink : public Link {
 public:
  SerialLink(std::string device, Port port, int fd)
      : device_(std::move(device)), port_(std::move(port)), fd_(fd) {}
  SerialLink(const SerialLink&) = delete;
  SerialLink& operator=(const SerialLink&) = delete;
  ~SerialLink() override {
    if (!port_) {
      ::close(fd_);
    } else {
      ::ioctl(fd_, TIOCNXCL);
    }
  }

  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (lost_) return tl::unexpected<Error>(*lost_);
    const Result<std::size_t> taken = write(out);
    if (!taken) return taken;
    const std::size_t before = in.size();
    if (const Result<void> alive = listen(*taken < out.size(), wait, in); !alive) {
      // What the wire has taken, or brought, counts: the loss is told by the next call.
      if (*taken == 0 && in.size() == before) return tl::unexpected<Error>(alive.error());
      lost_ = alive.error();
    }
    return taken;
  }

 private:
  /// Waits for bytes, and for room to write where `more` is to leave.
  Result<void> listen(bool more, Time wait, std::string& in) {
    pollfd events{fd_, POLLIN, 0};
    if (more) events.events |= POLLOUT;
    if (wait < Time::zero()) wait = Time::zero();
    const auto whole = std::chrono::duration_cast<std::chrono::seconds>(wait);
    const timespec limit{whole.count(), static_cast<long>((wait - whole).count())};
    if (::ppoll(&events, 1, &limit, nullptr) < 0 && errno != EINTR) return lost(std::strerror(errno));
    if ((events.revents & POLLIN) != 0) return read(in);
    if ((events.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return lost("the port has hung up");
    return {};
  }

  tl::unexpected<Error> lost(const std::string& reason) const {
    return fail(Code::kLink, device_ + ": connection lost: " + reason + "; check the cable and the power");
  }

  /// As much as fits into the system's buffer.
  Result<std::size_t> write(std::string_view out) {
    if (out.empty()) return 0;
    ssize_t count = 0;
    int reason = 0;
    if (port_) {
      count = sp_nonblocking_write(port_.get(), out.data(), out.size());
      if (count < 0) reason = sp_last_error_code();
    } else {
      count = ::write(fd_, out.data(), out.size());
      if (count < 0) reason = errno;
    }
    if (count >= 0) return static_cast<std::size_t>(count);
    if (reason == EAGAIN || reason == EINTR) return 0;
    return lost(std::strerror(reason));
  }

  /// What is there. Requires: poll has said so; then nothing at all means that the port has gone.
  Result<void> read(std::string& in) {
    const std::size_t before = in.size();
    for (;;) {
      const std::size_t size = in.size();
      in.resize(size + kReadSize);
      ssize_t count = 0;
      int reason = 0;
      if (port_) {
        count = sp_nonblocking_read(port_.get(), in.data() + size, kReadSize);
        if (count < 0) reason = sp_last_error_code();
      } else {
        count = ::read(fd_, in.data() + size, kReadSize);
        if (count < 0) reason = errno;
      }
      in.resize(size + static_cast<std::size_t>(count > 0 ? count : 0));
      if (count == static_cast<ssize_t>(kReadSize)) continue;
      if (count > 0 || in.size() > before) return {};
      if (count == 0) return lost("the port has hung up");
      if (reason == EAGAIN || reason == EINTR) return {};
      return lost(std::strerror(reason));
    }
  }

  std::string device_;
  Port port_;  // empty for a pseudo-terminal
  int fd_;
  std::optional<Error> lost_;  // seen by a call that had taken bytes
};

/// Keeps the modem lines up when the port is closed, so that the board is not reset; replies without the
/// 16 ms pause of USB adapters. Both only where the driver can. RTS/CTS is set here: libserialport 0.1.1 says
/// so where no driver looks (CRTSCTS among the input flags). False when the driver does not take that.
bool set_line_habits(int fd, bool rts_cts) {
  termios settings{};
  if (::tcgetattr(fd, &settings) != 0) return !rts_cts;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL | CRTSCTS);
  if (rts_cts) settings.c_cflag |= CRTSCTS;
  ::tcsetattr(fd, TCSANOW, &settings);
  serial_struct driver{};
  if (::ioctl(fd, TIOCGSERIAL, &driver) == 0) {
    driver.flags |= ASYNC_LOW_LATENCY;
    ::ioctl(fd, TIOCSSERIAL, &driver);
  }
  return ::tcgetattr(fd, &settings) == 0 && ((settings.c_cflag & CRTSCTS) != 0) == rts_cts;
}

std::string describe(const SerialFormat& format) {
  constexpr char kParities[] = {'N', 'E', 'O'};
  return std::to_string(format.baud) + " baud, " + std::to_string(format.data_bits) +
         kParities[static_cast<int>(format.parity)] + std::to_string(format.stop_bits) +
         (format.rts_cts ? ", RTS/CTS" : "");
}

sp_return set_format(sp_port* port, const SerialFormat& format) {
  constexpr sp_parity kParities[] = {SP_PARITY_NONE, SP_PARITY_EVEN, SP_PARITY_ODD};
  sp_return code = sp_set_baudrate(port, format.baud);
  if (code == SP_OK) code = sp_set_bits(port, format.data_bits);
  if (code == SP_OK) code = sp_set_parity(port, kParities[static_cast<int>(format.parity)]);
  if (code == SP_OK) code = sp_set_stopbits(port, format.stop_bits);
  if (code == SP_OK)
    code = sp_set_flowcontrol(port, format.rts_cts ? SP_FLOWCONTROL_RTSCTS : SP_FLOWCONTROL_NONE);
  return code;
}

Result<std::unique_ptr<Link>> open_port(const std::string& device, const SerialFormat& format, sp_port* raw) {
  Port port(raw);
  sp_return code = sp_open(raw, SP_MODE_READ_WRITE);
  if (code != SP_OK) return cannot_open(device, port_reason(code));
  int fd = -1;
  code = sp_get_port_handle(raw, &fd);
  if (code != SP_OK) return cannot_open(device, port_reason(code));
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) return cannot_open(device, "another program has it");
  if (::ioctl(fd, TIOCEXCL) != 0) return cannot_open(device, std::strerror(errno));
  if ((code = set_format(raw, format)) != SP_OK)
    return fail(Code::kLink, device + ": refuses " + describe(format) + ": " + port_reason(code));
  if (!set_line_habits(fd, format.rts_cts))
    return fail(Code::kLink,
                device + ": its driver has no RTS/CTS: take another adapter, or wire.dnc.flow xon_xoff");
  sp_flush(raw, SP_BUF_INPUT);
  return std::make_unique<SerialLink>(device, std::move(port), fd);
}

/// The exclusive flag would outlive a killed process here, since the other end keeps the terminal alive: a
/// file lock goes with its holder.
Result<std::unique_ptr<Link>> open_pseudo_terminal(const std::string& device) {
  const int fd = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return cannot_open(device, std::strerror(errno));
  auto link = std::make_unique<SerialLink>(device, Port(), fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) return cannot_open(device, "another program has it");
  termios settings{};
  if (::tcgetattr(fd, &settings) != 0) return cannot_open(device, std::strerror(errno));
  ::cfmakeraw(&settings);
  if (::tcsetattr(fd, TCSANOW, &settings) != 0) return cannot_open(device, std::strerror(errno));
  ::tcflush(fd, TCIFLUSH);
  return link;
}

}  // namespace

Result<std::unique_ptr<Link>> open_serial_link(const std::string& device, const SerialFormat& format) {
  const std::unique_ptr<char, decltype(&std::free)> resolved(::realpath(device.c_str(), nullptr), &std::free);
  if (!resolved) return cannot_open(device, std::strerror(errno));
  const std::string place = resolved.get();
  sp_port* port = nullptr;
  const sp_return code = sp_get_port_by_name(place.c_str(), &port);
  if (code == SP_OK) return open_port(place, format, port);
  if (place.starts_with(kPseudoTerminals)) return open_pseudo_terminal(place);
  return cannot_open(device, port_reason(code));
}

}  // namespace tiltfeed::daemon
