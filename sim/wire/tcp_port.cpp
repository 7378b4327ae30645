#include "sim/wire/tcp_port.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

namespace tiltfeed::sim {

Result<TcpPort> TcpPort::open(const std::string& place) {
  const std::size_t colon = place.rfind(':');
  sockaddr_in address{};
  address.sin_family = AF_INET;
  int port = -1;
  if (colon != place.npos) std::from_chars(place.data() + colon + 1, place.data() + place.size(), port);
  if (port < 0 || port > 65535 || inet_pton(AF_INET, place.substr(0, colon).c_str(), &address.sin_addr) != 1)
    return fail(Code::kUsage, "'" + place + "' is not an address with a port, such as 127.0.0.1:2300");
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  TcpPort made;
  made.listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  setsockopt(made.listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  socklen_t size = sizeof address;
  if (::bind(made.listener_, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      ::listen(made.listener_, 1) != 0 ||
      ::getsockname(made.listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    return fail(Code::kIo, place + ": " + std::strerror(errno));
  made.place_ = place.substr(0, colon + 1) + std::to_string(ntohs(address.sin_port));
  return made;
}

TcpPort::~TcpPort() {
  part();
  if (listener_ >= 0) ::close(listener_);
}

bool TcpPort::welcome() {
  if (host_ >= 0) return false;
  host_ = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  const int on = 1;
  if (host_ >= 0) setsockopt(host_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return host_ >= 0;
}

void TcpPort::part() {
  if (host_ >= 0) ::close(host_);
  host_ = -1;
}

}  // namespace tiltfeed::sim
