#include "daemon/service/api_socket.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/service/api.h"

namespace tiltfeed::daemon {

namespace {

constexpr std::size_t kFilesPerRequest = 2;
constexpr std::size_t kMaxReply = 4u << 20;  // a full spool, listed
constexpr mode_t kSocketMode = 0660;
/// A submission has time until CopyProcess loses its patience.
constexpr std::chrono::seconds kAnswerWait{330};

bool fill_address(const std::string& path, sockaddr_un& address) {
  address = {};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) return false;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  return true;
}

bool connects(int fd, const sockaddr_un& address) {
  return ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

tl::unexpected<Error> socket_error(const std::string& path, const char* what) {
  return fail(Code::kIo, path + ": " + what + ": " + std::strerror(errno));
}

}  // namespace

Result<ApiSocket> ApiSocket::open(const std::string& path) {
  sockaddr_un address;
  if (!fill_address(path, address)) return fail(Code::kIo, path + ": is too long for a socket's name");
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return socket_error(path, "no socket");
  ApiSocket socket({}, fd);
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool taken = connects(probe, address);
  ::close(probe);
  if (taken) return fail(Code::kIo, path + ": another service answers there");
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode)) ::unlink(path.c_str());
  const mode_t old = ::umask(0777 & ~kSocketMode);
  const bool bound = ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::umask(old);
  if (!bound) return socket_error(path, "cannot be made");
  socket.path_ = path;
  if (::listen(fd, static_cast<int>(kClients)) != 0) return socket_error(path, "cannot be listened to");
  return socket;
}

ApiSocket::ApiSocket(ApiSocket&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      fd_(std::exchange(other.fd_, -1)),
      last_(other.last_),
      clients_(std::move(other.clients_)) {
  other.clients_.clear();
}

ApiSocket::~ApiSocket() {
  for (const Client& client : clients_) ::close(client.fd);
  if (fd_ >= 0) ::close(fd_);
  if (!path_.empty()) ::unlink(path_.c_str());
}

void ApiSocket::add_to(std::vector<pollfd>& polled) const {
  polled.push_back({fd_, POLLIN, 0});
  for (const Client& client : clients_) {
    // Of one that waits for its reply only that it has gone.
    const short events = !client.out.empty() ? POLLOUT : client.waits ? 0 : POLLIN;
    polled.push_back({client.fd, events, 0});
  }
}

std::size_t ApiSocket::waiting() const {
  return static_cast<std::size_t>(
      std::count_if(clients_.begin(), clients_.end(), [](const Client& client) { return client.waits; }));
}

/// Whoever comes next may be an operator with an order.
void ApiSocket::make_room() {
  if (clients_.size() - waiting() < kClients) return;
  auto oldest = clients_.end();
  for (auto at = clients_.begin(); at != clients_.end(); ++at)
    if (!at->waits && (oldest == clients_.end() || at->heard < oldest->heard)) oldest = at;
  ::close(oldest->fd);
  clients_.erase(oldest);
}

void ApiSocket::accept_clients() {
  for (std::size_t i = 0; i < kClients; ++i) {  // the rest in the next turn
    const int fd = ::accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    ucred peer{};
    socklen_t size = sizeof peer;
    if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) {
      ::close(fd);
      continue;
    }
    make_room();
    clients_.push_back({fd, ++last_, peer.uid, {}, {}, HandedFiles(), std::chrono::steady_clock::now()});
  }
}

void ApiSocket::serve(const std::vector<pollfd>& polled, const ApiTaker& take) {
  const auto now = std::chrono::steady_clock::now();
  const auto events_of = [&](int fd) {
    for (const pollfd& p : polled)
      if (p.fd == fd) return p.revents;
    return short{0};
  };
  for (Client& client : clients_) {
    const short events = events_of(client.fd);
    if (events != 0) client.heard = now;
    if (events != 0 && !talk(client, events, take)) client.gone = true;
    if (!client.waits && now - client.heard >= kPatience) client.gone = true;
  }
  std::erase_if(clients_, [](const Client& client) {
    if (client.gone) ::close(client.fd);
    return client.gone;
  });
  if (events_of(fd_) != 0) accept_clients();
}

/// False when the client has gone or misbehaves.
bool ApiSocket::talk(Client& client, short events, const ApiTaker& take) {
  if ((events & POLLOUT) != 0) return send_out(client) && take_lines(client, take);
  if ((events & POLLIN) == 0) return false;  // hung up
  return receive(client) && take_lines(client, take);
}

bool ApiSocket::send_out(Client& client) {
  const ssize_t sent = ::send(client.fd, client.out.data(), client.out.size(), MSG_NOSIGNAL);
  if (sent < 0) return errno == EAGAIN || errno == EINTR;
  client.out.erase(0, static_cast<std::size_t>(sent));
  return true;
}

/// One after the other, each when the one before is answered: whoever sends many gets no stack full of them.
bool ApiSocket::take_lines(Client& client, const ApiTaker& take) {
  client.taken_of = true;
  while (!client.waits && !client.gone && client.out.empty()) {
    const std::size_t end = client.in.find('\n');
    client.gone = std::min(end, client.in.size()) > kMaxRequest;
    if (end == std::string::npos || client.gone) break;
    Asked asked{client.id, client.in.substr(0, end), client.user, std::move(client.files)};
    client.files = HandedFiles();
    client.in.erase(0, end + 1);
    client.waits = true;
    take(std::move(asked));
  }
  client.taken_of = false;
  return !client.gone;
}

void ApiSocket::reply(std::uint64_t id, const std::string& line, const ApiTaker& take) {
  for (Client& client : clients_) {
    if (client.id != id || !client.waits) continue;
    client.waits = false;
    client.heard = std::chrono::steady_clock::now();
    client.out = line;
    if (!send_out(client) || (!client.taken_of && !take_lines(client, take))) client.gone = true;
    return;
  }
}

bool ApiSocket::receive(Client& client) {
  char bytes[kMaxRequest];
  iovec into{bytes, sizeof bytes};
  alignas(cmsghdr) char control[CMSG_SPACE(kFilesPerRequest * sizeof(int))];
  msghdr message{};
  message.msg_iov = &into;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t size = ::recvmsg(client.fd, &message, MSG_CMSG_CLOEXEC);
  if (size < 0) return errno == EAGAIN || errno == EINTR;
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (part->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(part) + i * sizeof(int), sizeof fd);
      client.files.add(fd);
    }
  }
  if (size == 0 || (message.msg_flags & MSG_CTRUNC) != 0 || client.files.all().size() > kFilesPerRequest)
    return false;
  client.in.append(bytes, static_cast<std::size_t>(size));
  return true;
}

// ---- the client's end
// --------------------------------------------------------------------------------------

Result<std::string> ask_service(const std::string& path, const std::string& line,
                                const std::vector<int>& files) {
  return ask_service(path, line, files, kAnswerWait);
}

Result<std::string> ask_service(const std::string& path, const std::string& line,
                                const std::vector<int>& files, std::chrono::seconds patience) {
  sockaddr_un address;
  if (!fill_address(path, address)) return fail(Code::kIo, path + ": is too long for a socket's name");
  struct Descriptor {
    int fd;
    ~Descriptor() { ::close(fd); }
  } const wire{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  const auto silent = [&] {
    return fail(Code::kLink, path + ": no answer within " + std::to_string(patience.count()) + " s");
  };
  const auto interrupted = [&] {
    return fail(Code::kLink, path +
                                 ": interrupted before the service answered; whether it has taken the "
                                 "order is not known: look with `tiltfeed list`");
  };
  // Of connecting, too: a service that hangs lets some in and then nobody.
  const timeval limit{patience.count(), 0};
  ::setsockopt(wire.fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  if (!connects(wire.fd, address)) {
    if (errno == EAGAIN) return silent();
    if (errno == EINTR) return fail(Code::kLink, path + ": interrupted; the service was not asked");
    return fail(Code::kIo, path + ": " + std::strerror(errno) +
                               "; is `tiltfeed serve` running, and are you in its group?");
  }
  iovec from{const_cast<char*>(line.data()), line.size()};
  alignas(cmsghdr) char control[CMSG_SPACE(kFilesPerRequest * sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &from;
  message.msg_iovlen = 1;
  if (!files.empty()) {
    message.msg_control = control;
    message.msg_controllen = CMSG_SPACE(files.size() * sizeof(int));
    cmsghdr* const part = CMSG_FIRSTHDR(&message);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(files.size() * sizeof(int));
    std::memcpy(CMSG_DATA(part), files.data(), files.size() * sizeof(int));
  }
  if (::sendmsg(wire.fd, &message, MSG_NOSIGNAL) != static_cast<ssize_t>(line.size()))
    return socket_error(path, "cannot be asked");
  const int wait_ms = static_cast<int>(std::chrono::milliseconds(patience).count());
  std::string in;
  char bytes[65536];
  while (in.find('\n') == std::string::npos) {
    pollfd ready{wire.fd, POLLIN, 0};
    const int events = ::poll(&ready, 1, wait_ms);
    if (events < 0 && errno == EINTR) return interrupted();
    if (events <= 0) return silent();
    const ssize_t size = ::read(wire.fd, bytes, sizeof bytes);
    if (size <= 0 || in.size() > kMaxReply)
      return fail(Code::kIo, path + ": the service closed the connection");
    in.append(bytes, static_cast<std::size_t>(size));
  }
  return in.substr(0, in.find('\n'));
}

}  // namespace tiltfeed::daemon
