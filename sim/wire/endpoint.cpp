#include "sim/wire/endpoint.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <type_traits>

#include "sim/wire/baud_clock.h"
#include "sim/wire/faulty_line.h"
#include "sim/wire/pty.h"
#include "sim/wire/tcp_port.h"
#include "sim/wire/ws_port.h"

namespace tiltfeed::sim {
namespace {

// What the host does not read within this many bytes is lost, as on a wire that nobody listens to.
constexpr std::size_t kMostUnread = 1 << 20;
constexpr std::size_t kReadBytes = 65536;

/// A host that has gone is no signal.
ssize_t write_quietly(int fd, const char* bytes, std::size_t size) {
  const ssize_t sent = send(fd, bytes, size, MSG_NOSIGNAL);
  return sent < 0 && errno == ENOTSOCK ? write(fd, bytes, size) : sent;
}

/// Writes what the terminal takes; true when something was written.
bool drain(int fd, std::string& unsent) {
  if (unsent.empty()) return false;
  const ssize_t written = write_quietly(fd, unsent.data(), unsent.size());
  if (written > 0) unsent.erase(0, static_cast<std::size_t>(written));
  return written > 0;
}

constexpr int kAlarmHardLimit = 1;  // of the Grbl family
void perform_alarm(GrblController& controller) { controller.raise_alarm(kAlarmHardLimit); }
void perform_alarm(RepRapController& controller) { controller.halt(); }
void perform_alarm(DripController& controller) { controller.raise_alarm(kAlarmFraming); }
void perform_reset(GrblController& controller) { controller.receive("\x18"); }
void perform_reset(RepRapController& controller) { controller.reset(); }
void perform_reset(DripController& controller) { controller.reset(); }

// How often a control that waits for its program says so, s.
constexpr double kInviteEvery = 0.5;
void invite(GrblController&) {}
void invite(RepRapController&) {}
void invite(DripController& controller) { controller.invite(); }

void greet(GrblController& controller) { controller.greet(); }
void greet(RepRapController&) {}
void greet(DripController&) {}

// What a port puts round the machine's bytes, and whether it has done with its host.
template <class Port>
std::string from_host(Port&, std::string bytes) {
  return bytes;
}
std::string from_host(WsPort& port, const std::string& bytes) { return port.decode(bytes); }
template <class Port>
std::string for_host(Port&, std::string bytes) {
  return bytes;
}
std::string for_host(WsPort& port, const std::string& bytes) { return port.encode(bytes); }
template <class Port>
bool leaves(const Port&) {
  return false;
}
bool leaves(const WsPort& port) { return port.leaves(); }

/// A controller behind a terminal or a socket whose line has a speed and faults.
template <class Controller, class Port = Pty>
class Endpoint {
 public:
  Endpoint(Controller& controller, std::string path, const EndpointOptions& options)
      : controller_(controller),
        path_(std::move(path)),
        options_(options),
        pace_(options.speed),
        line_(options.faults),
        speed_(options.byte_time) {}

  Result<void> serve() {
    if (const Result<void> opened = open(); !opened) return opened;
    while (true) {
      std::array<pollfd, 2> fds{{{waiting_ ? -1 : pty_->master(), POLLIN, 0}, {options_.stop_fd, POLLIN, 0}}};
      if (!unsent_.empty() && !waiting_) fds[0].events |= POLLOUT;
      double wait = pace_.wait(controller_);
      if (waiting_ || !options_.faults.rules.empty()) wait = std::min(wait, kLineTick);
      const timespec timeout{0, static_cast<long>(wait * 1e9)};
      if (ppoll(fds.data(), fds.size(), &timeout, nullptr) < 0 && errno != EINTR)
        return fail(Code::kIo, path_ + ": " + std::strerror(errno));
      if (fds[1].revents != 0) break;
      if (const Result<void> there = follow_disconnect(); !there) return there;
      pace_.follow(controller_);
      if (pace_.real() - invited_ >= kInviteEvery) {
        invited_ = pace_.real();
        invite(controller_);
      }
      const bool traffic = exchange(waiting_ || (fds[0].revents & POLLIN) != 0);
      if (traffic || controller_.next_event()) last_traffic_ = pace_.real();
      if (pace_.time_to_flush()) options_.flush();
      if (options_.once && controller_.program_ended() && pace_.real() - last_traffic_ >= kQuietEnd) break;
    }
    if (options_.line) options_.line(speed_.bytes(), speed_.use());
    options_.flush();
    return {};
  }

 private:
  static constexpr double kLineTick = 0.001;  // of a paced line, s

  Result<void> open() {
    Result<Port> pty = Port::open(path_);
    if (!pty) return tl::unexpected<Error>(std::move(pty.error()));
    pty_.emplace(std::move(*pty));
    fcntl(pty_->master(), F_SETFL, fcntl(pty_->master(), F_GETFL) | O_NONBLOCK);
    const bool named = path_ == pty_->device();
    if (!std::is_same_v<Port, Pty>) path_ = pty_->device();  // where it will be again after a disconnect
    options_.ready(std::is_same_v<Port, Pty> && !named ? path_ + " (" + pty_->device() + ")" : path_);
    return {};
  }

  /// Away: the terminal is closed, its link gone. Back: another terminal.
  Result<void> follow_disconnect() {
    const bool away = line_.away(pace_.real());
    if (away && pty_) {
      pty_.reset();
      unsent_.clear();
      waiting_ = false;
    }
    while (line_.away(pace_.real())) {
      const timespec tick{0, static_cast<long>(kLineTick * 1e9)};
      nanosleep(&tick, nullptr);
    }
    return pty_ ? Result<void>() : open();
  }

  /// True when bytes passed either way.
  bool exchange(bool readable) {
    const double now = pace_.real();
    const std::size_t most = speed_.allowed(now, line_.slow_read() ? 1 : bytes_.size());
    ssize_t count = 0;
    if (readable && pty_->welcome()) {
      greet(controller_);
      return true;
    }
    if (readable && most > 0 && pty_->connected()) {
      count = read(pty_->master(), bytes_.data(), most);
      if (count == 0 || (count < 0 && errno == ECONNRESET)) pty_->part();
    }
    waiting_ = speed_.paced() && readable && (count > 0 || most == 0);
    if (!waiting_) speed_.idle();
    if (count > 0) {
      speed_.passed(static_cast<std::size_t>(count));
      line_.to_machine(from_host(*pty_, std::string(bytes_.data(), static_cast<std::size_t>(count))), now);
    }
    if (line_.reset_due(now)) perform_reset(controller_);
    if (line_.alarm_due(now)) perform_alarm(controller_);
    const std::string arrived = line_.at_machine(now);
    if (!arrived.empty()) {
      controller_.receive(arrived);
    } else if (!waiting_) {
      pace_.jump(controller_);
    }
    if (controller_.has_output()) line_.to_host(controller_.take_output(), now);
    unsent_ += for_host(*pty_, line_.at_host(now));
    if (unsent_.size() > kMostUnread || !pty_->connected()) unsent_.clear();
    const bool drained = drain(pty_->master(), unsent_);
    if (leaves(*pty_) && unsent_.empty()) pty_->part();
    return drained || count > 0;
  }

  Controller& controller_;
  std::string path_;
  const EndpointOptions& options_;
  SimClock pace_;
  FaultyLine line_;
  BaudClock speed_;
  std::optional<Port> pty_;
  std::array<char, kReadBytes> bytes_{};
  std::string unsent_;
  double last_traffic_ = 0.0, invited_ = 0.0;
  bool waiting_ = false;  ///< bytes may lie in the terminal that the line has not carried yet
};

}  // namespace

Result<void> serve_pty(GrblController& controller, const std::string& path, EndpointOptions options) {
  return Endpoint(controller, path, options).serve();
}
Result<void> serve_pty(RepRapController& controller, const std::string& path, EndpointOptions options) {
  return Endpoint(controller, path, options).serve();
}
Result<void> serve_pty(DripController& controller, const std::string& path, EndpointOptions options) {
  return Endpoint(controller, path, options).serve();
}

Result<void> serve_tcp(GrblController& controller, const std::string& place, EndpointOptions options) {
  return Endpoint<GrblController, TcpPort>(controller, place, options).serve();
}
Result<void> serve_ws(GrblController& controller, const std::string& place, EndpointOptions options) {
  return Endpoint<GrblController, WsPort>(controller, place, options).serve();
}

}  // namespace tiltfeed::sim
