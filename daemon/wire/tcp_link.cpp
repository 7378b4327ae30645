#include "daemon/wire/tcp_link.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace tiltfeed::daemon {

namespace {

constexpr int kConnectMs = 5000;
/// Bytes that nobody takes for so long are the sign of a pulled cable; so is silence of that length.
constexpr unsigned kUnheardMs = 5000;
constexpr int kProbeSeconds = 2, kProbes = 2;

class Socket {
 public:
  explicit Socket(int fd = -1) : fd_(fd) {}
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&&) = delete;
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

template <class Value>
void set(int fd, int level, int name, Value value) {
  ::setsockopt(fd, level, name, &value, sizeof value);
}

/// 0, or the errno of the attempt.
int connect_within(int fd, const addrinfo& to) {
  if (::connect(fd, to.ai_addr, to.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  pollfd ready{fd, POLLOUT, 0};
  if (::poll(&ready, 1, kConnectMs) == 0) return ETIMEDOUT;
  int reason = 0;
  socklen_t size = sizeof reason;
  return ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &reason, &size) == 0 ? reason : errno;
}

class TcpLink : public Link {
 public:
  TcpLink(Socket socket, std::string name) : socket_(std::move(socket)), name_(std::move(name)) {}

  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (lost_ != 0) return gone();
    pollfd ready{socket_.fd(), static_cast<short>(out.empty() ? POLLIN : POLLIN | POLLOUT), 0};
    const auto span = std::max<Time::rep>(wait.count(), 0);
    constexpr Time::rep kSecond = 1'000'000'000;
    const timespec limit{span / kSecond, span % kSecond};
    if (::ppoll(&ready, 1, &limit, nullptr) <= 0) return std::size_t{0};
    std::size_t taken = 0;
    // Bytes first: what the connection took counts, whatever comes after.
    if ((ready.revents & POLLOUT) != 0) {
      const ssize_t sent = ::send(socket_.fd(), out.data(), out.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) taken = static_cast<std::size_t>(sent);
      if (sent < 0 && errno != EAGAIN && errno != EINTR) lost_ = errno;
    }
    const std::size_t before = in.size();
    if ((ready.revents & (POLLIN | POLLHUP | POLLERR)) != 0) receive(in);
    // Nothing taken and nothing come: it is told at once.
    if (lost_ != 0 && taken == 0 && in.size() == before) return gone();
    return taken;
  }

 private:
  void receive(std::string& in) {
    char bytes[4096];
    const ssize_t size = ::recv(socket_.fd(), bytes, sizeof bytes, MSG_DONTWAIT);
    if (size > 0) in.append(bytes, static_cast<std::size_t>(size));
    if (size == 0) lost_ = ECONNRESET;
    if (size < 0 && errno != EAGAIN && errno != EINTR) lost_ = errno;
  }
  tl::unexpected<Error> gone() const {
    return fail(Code::kLink,
                name_ + ": connection lost: " + std::strerror(lost_) +
                    "; check the controller's power, its network cable and whether another program "
                    "has connected to it");
  }

  Socket socket_;
  std::string name_;
  int lost_ = 0;  // errno
};

}  // namespace

Result<std::unique_ptr<Link>> open_tcp_link(const LinkSpec& link) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  const std::string name = describe(link);
  if (const int wrong = ::getaddrinfo(link.place.c_str(), std::to_string(link.port).c_str(), &hints, &found);
      wrong != 0)
    return fail(Code::kLink, name + ": " + ::gai_strerror(wrong) + "; check the name");
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, ::freeaddrinfo);
  int reason = 0;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    Socket socket(::socket(one->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (socket.fd() < 0) {
      reason = errno;
      continue;
    }
    reason = connect_within(socket.fd(), *one);
    if (reason != 0) continue;
    set(socket.fd(), IPPROTO_TCP, TCP_NODELAY, 1);
    set(socket.fd(), IPPROTO_TCP, TCP_USER_TIMEOUT, kUnheardMs);
    set(socket.fd(), SOL_SOCKET, SO_KEEPALIVE, 1);
    set(socket.fd(), IPPROTO_TCP, TCP_KEEPIDLE, kProbeSeconds);
    set(socket.fd(), IPPROTO_TCP, TCP_KEEPINTVL, kProbeSeconds);
    set(socket.fd(), IPPROTO_TCP, TCP_KEEPCNT, kProbes);
    return std::make_unique<TcpLink>(std::move(socket), name);
  }
  return fail(Code::kLink,
              name + ": cannot connect: " + std::strerror(reason) +
                  "; check that the controller is on, its address and port, and that no other program is "
                  "connected to it");
}

}  // namespace tiltfeed::daemon
