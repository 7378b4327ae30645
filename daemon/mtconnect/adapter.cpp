#include "daemon/mtconnect/adapter.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

namespace tiltfeed::daemon {
namespace {

constexpr std::size_t kLongestLine = 1024;
constexpr int kBacklog = 8;

std::string time_text() {
  const auto now = std::chrono::system_clock::now();
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[40];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  const auto whole =
      std::chrono::time_point_cast<std::chrono::milliseconds>(now).time_since_epoch().count() % 1000;
  char thousandths[8];
  std::snprintf(thousandths, sizeof thousandths, ".%03dZ", static_cast<int>(whole));
  return std::string(text) + thousandths;
}

/// The address that a socket got, as HOST:PORT.
std::string bound_address(int fd, const std::string& host) {
  sockaddr_storage got{};
  socklen_t size = sizeof got;
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&got), &size);
  const auto port = got.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(got).sin6_port
                                              : reinterpret_cast<const sockaddr_in&>(got).sin_port;
  return host + ":" + std::to_string(ntohs(port));
}

}  // namespace

Result<Adapter> Adapter::open(const std::string& address, std::vector<DataItem> items, std::string version) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size())
    return fail(Code::kUsage, address + ": HOST:PORT, such as 127.0.0.1:7878");
  const std::string host = address.substr(0, colon), port = address.substr(colon + 1);
  std::string name = host;
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') name = name.substr(1, name.size() - 2);
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  if (const int error = ::getaddrinfo(name.c_str(), port.c_str(), &wanted, &found); error != 0)
    return fail(Code::kUsage, address + ": " + ::gai_strerror(error) + "; HOST:PORT, such as 127.0.0.1:7878");
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, ::freeaddrinfo);
  const int fd = ::socket(list->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  if (fd >= 0) ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (fd < 0 || ::bind(fd, list->ai_addr, list->ai_addrlen) != 0 || ::listen(fd, kBacklog) != 0) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) ::close(fd);
    return fail(Code::kIo, address + ": cannot listen: " + why);
  }
  return Adapter(fd, bound_address(fd, host), std::move(items), std::move(version));
}

Adapter::Adapter(Adapter&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      address_(std::move(other.address_)),
      items_(std::move(other.items_)),
      version_(std::move(other.version_)),
      now_(std::move(other.now_)),
      agents_(std::exchange(other.agents_, {})) {}

Adapter::~Adapter() {
  for (const Agent& agent : agents_) ::close(agent.fd);
  if (fd_ >= 0) ::close(fd_);
}

void Adapter::tell(const Observations& now) {
  const std::string lines = shdr_lines(items_, now_.empty() ? nullptr : &now_, now, time_text());
  now_ = now;
  for (Agent& agent : agents_) agent.out += lines, send_out(agent);
}

void Adapter::serve(std::chrono::milliseconds patience) {
  std::vector<pollfd> polled = {{fd_, POLLIN, 0}};
  for (const Agent& agent : agents_)
    polled.push_back({agent.fd, static_cast<short>(agent.out.empty() ? POLLIN : POLLIN | POLLOUT), 0});
  if (::poll(polled.data(), polled.size(), static_cast<int>(patience.count())) > 0) {
    std::size_t at = 1;
    for (Agent& agent : agents_) talk(agent, polled[at++].revents);
    if (polled[0].revents != 0) accept_agents();
  }
  const Time now = std::chrono::steady_clock::now();
  agents_.remove_if([&](const Agent& agent) {
    const bool lost =
        agent.gone || agent.out.size() > kMostUnread || (agent.pings && now - agent.heard > 2 * kPeriod);
    if (lost) ::close(agent.fd);
    return lost;
  });
}

void Adapter::accept_agents() {
  for (int fd = -1; (fd = ::accept4(fd_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0;) {
    if (agents_.size() >= kAgents) {
      ::close(fd);
      continue;
    }
    Agent agent;
    agent.fd = fd;
    agent.heard = std::chrono::steady_clock::now();
    agent.out = "* shdrVersion: 1\n* adapterVersion: " + version_ + "\n* manufacturer: Tiltfeed\n";
    if (!now_.empty()) agent.out += shdr_lines(items_, nullptr, now_, time_text());
    send_out(agent);
    agents_.push_back(std::move(agent));
  }
}

void Adapter::talk(Agent& agent, short events) {
  if ((events & POLLOUT) != 0) send_out(agent);
  if ((events & (POLLIN | POLLHUP | POLLERR)) == 0) return;
  char bytes[kLongestLine];
  const ssize_t size = ::recv(agent.fd, bytes, sizeof bytes, 0);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) {
    agent.gone = true;
    return;
  }
  agent.heard = std::chrono::steady_clock::now();
  agent.in.append(bytes, static_cast<std::size_t>(size));
  for (std::size_t end; (end = agent.in.find('\n')) != std::string::npos; agent.in.erase(0, end + 1))
    if (agent.in.starts_with("* PING")) {
      agent.pings = true;
      agent.out += "* PONG " + std::to_string(kPeriod.count()) + "\n";
    }
  if (agent.in.size() > kLongestLine) agent.gone = true;  // no agent says so much
  send_out(agent);
}

void Adapter::send_out(Agent& agent) {
  while (!agent.out.empty()) {
    const ssize_t size = ::send(agent.fd, agent.out.data(), agent.out.size(), MSG_NOSIGNAL);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      agent.gone = agent.gone || errno != EAGAIN;
      return;
    }
    agent.out.erase(0, static_cast<std::size_t>(size));
  }
}

}  // namespace tiltfeed::daemon
