#include "desk/service/service_call.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kMostFiles = 2;  // of a request

bool sent(int fd, const std::string& line, const std::vector<int>& files) {
  iovec from{const_cast<char*>(line.data()), line.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(kMostFiles * sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &from;
  message.msg_iovlen = 1;
  if (!files.empty()) {
    message.msg_control = control.data();
    message.msg_controllen = CMSG_SPACE(files.size() * sizeof(int));
    cmsghdr* const part = CMSG_FIRSTHDR(&message);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(files.size() * sizeof(int));
    std::memcpy(CMSG_DATA(part), files.data(), files.size() * sizeof(int));
  }
  // A request is far shorter than the buffer of a new connection: it goes whole.
  return ::sendmsg(fd, &message, MSG_NOSIGNAL) == static_cast<ssize_t>(line.size());
}

}  // namespace

Result<ServiceCall> ServiceCall::start(const std::string& socket, const std::string& line,
                                       const std::vector<int>& files) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket.empty() || socket.size() >= sizeof address.sun_path || files.size() > kMostFiles)
    return fail(Code::kIo, socket + ": is no name of a socket");
  std::memcpy(address.sun_path, socket.c_str(), socket.size() + 1);
  ServiceCall call(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (::connect(call.fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      !sent(call.fd_, line, files))
    return fail(Code::kIo, socket + ": " + std::strerror(errno));
  return call;
}

ServiceCall::ServiceCall(ServiceCall&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), got_(std::move(other.got_)) {}

ServiceCall::~ServiceCall() {
  if (fd_ >= 0) ::close(fd_);
}

std::optional<Result<std::string>> ServiceCall::hear() {
  std::array<char, 65536> block{};
  while (true) {
    const ssize_t count = ::read(fd_, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return std::nullopt;
    if (count <= 0) return Result<std::string>(fail(Code::kIo, "the service closed the connection"));
    got_.append(block.data(), static_cast<std::size_t>(count));
    if (const std::size_t end = got_.find('\n'); end != std::string::npos)
      return Result<std::string>(got_.substr(0, end));
    if (got_.size() > kMaxReply)
      return Result<std::string>(fail(Code::kIo, "the service's answer does not end"));
  }
}

}  // namespace tiltfeed::desk
