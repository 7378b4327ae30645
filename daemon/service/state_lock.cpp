#include "daemon/service/state_lock.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "daemon/files/sha256.h"

namespace tiltfeed::daemon {

namespace {

constexpr int kAsking = 8;  // who may ask at once who has a machine
constexpr const char* kPrefix = "tiltfeed/machine/";

std::string process_text(long pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/cmdline", std::ios::binary);
  std::string words{std::istreambuf_iterator<char>(in), {}};
  while (!words.empty() && words.back() == '\0') words.pop_back();
  for (char& c : words)
    if (c < ' ' || c > '~') c = ' ';
  return "process " + std::to_string(pid) + (words.empty() ? "" : " (" + words + ")");
}

/// Connects and binds to this address on this computer only, whatever the address is called.
bool is_own(const sockaddr* address, socklen_t size) {
  const int fd = ::socket(address->sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const bool bound = ::bind(fd, address, size) == 0;
  ::close(fd);
  return bound;
}

constexpr const char* kOwn = "this computer";
/// A board that has a WebSocket has a plain connection, too: both lead to the one machine. A host of several
/// plain connections is a server of serial ports, with a machine at each.
constexpr const char *kSocketWay = " websocket", *kPlainWay = " plain";

/// Without the port.
std::string address_text(const addrinfo& found) {
  sockaddr_in v4{};
  sockaddr_in6 v6{};
  char text[INET6_ADDRSTRLEN] = {};
  if (found.ai_family == AF_INET) {
    std::memcpy(&v4, found.ai_addr, sizeof v4);
  } else {
    std::memcpy(&v6, found.ai_addr, sizeof v6);
    if (IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr)) {
      v4.sin_family = AF_INET;
      std::memcpy(&v4.sin_addr, v6.sin6_addr.s6_addr + 12, sizeof v4.sin_addr);
    }
  }
  v4.sin_port = v6.sin6_port = 0;
  const bool is_v4 = v4.sin_family == AF_INET;
  if (is_v4 ? is_own(reinterpret_cast<const sockaddr*>(&v4), sizeof v4)
            : is_own(reinterpret_cast<const sockaddr*>(&v6), sizeof v6))
    return kOwn;
  if (is_v4)
    ::inet_ntop(AF_INET, &v4.sin_addr, text, sizeof text);
  else
    ::inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof text);
  return text;
}

socklen_t address_of(const std::string& key, sockaddr_un& address) {
  address = {};
  address.sun_family = AF_UNIX;
  std::string name = kPrefix + key;
  if (name.size() >= sizeof address.sun_path) name = kPrefix + hex(sha256(key));
  std::memcpy(address.sun_path + 1, name.data(), name.size());  // the abstract namespace
  return static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
}

std::string holder_of(const std::string& key) {
  sockaddr_un address;
  const socklen_t size = address_of(key, address);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  ucred peer{};
  socklen_t length = sizeof peer;
  const bool known = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                     ::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &length) == 0;
  ::close(fd);
  return known ? process_text(peer.pid) : "another process";
}

/// The claim that another has on the board of these keys by its other way; empty: none has.
std::string claimed_the_other_way(const std::vector<std::string>& keys,
                                  const std::map<std::string, int>& own) {
  std::vector<std::string> others;
  for (const std::string& key : keys)
    for (const auto& [way, other] : {std::pair(kSocketWay, kPlainWay), std::pair(kPlainWay, kSocketWay)})
      if (const std::size_t at = key.find(way); at != key.npos) others.push_back(key.substr(0, at) + other);
  if (others.empty()) return "";
  std::ifstream claims("/proc/net/unix");
  const std::string mark = std::string("@") + kPrefix;
  for (std::string line; std::getline(claims, line);) {
    const std::size_t at = line.find(mark);
    if (at == line.npos) continue;
    const std::string key = line.substr(at + mark.size());
    for (const std::string& begin : others)
      if (key.starts_with(begin) && !own.contains(key)) return key;
  }
  return "";
}

/// The socket whose name is the claim. Errors: kUsage, kIo.
Result<int> claim(const std::string& key, const LinkSpec& link) {
  sockaddr_un address;
  const socklen_t size = address_of(key, address);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return fail(Code::kIo, std::string("no socket: ") + std::strerror(errno));
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0 && ::listen(fd, kAsking) == 0)
    return fd;
  const int why = errno;
  ::close(fd);
  if (why != EADDRINUSE)
    return fail(Code::kIo, describe(link) + ": cannot be claimed: " + std::strerror(why));
  return fail(Code::kUsage, describe(link) + " leads to a machine (" + key + ") that " + holder_of(key) +
                                " serves already: one service a machine, whatever name it has");
}

}  // namespace

Result<StateLock> StateLock::take(const std::string& folder) {
  const std::string path = folder + "/lock";
  StateLock lock;
  // The folder itself, too: a lock file that somebody has removed is no lock. Where a file system locks no
  // folders, the file alone.
  lock.folder_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  bool taken = ::flock(lock.folder_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  lock.file_ =
      ::open(path.c_str(), O_RDWR | (taken ? 0 : O_CREAT) | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (lock.file_ < 0 && !taken) return fail(Code::kIo, path + ": cannot be opened: " + std::strerror(errno));
  if (!taken && ::flock(lock.file_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return fail(Code::kIo, path + ": cannot be locked: " + std::strerror(errno));
    taken = true;
  }
  char text[32] = {};
  if (taken) {
    long pid = 0;
    const ssize_t size = ::pread(lock.file_, text, sizeof text - 1, 0);
    std::from_chars(text, text + std::max<ssize_t>(size, 0), pid);
    return fail(Code::kUsage, folder + " is in use by " + (pid > 0 ? process_text(pid) : "another process") +
                                  ": one service a spool; nothing in it was changed");
  }
  // For whom comes second; where it cannot be written the lock holds all the same.
  const int size = std::snprintf(text, sizeof text, "%ld\n", static_cast<long>(::getpid()));
  if (::ftruncate(lock.file_, 0) == 0)
    static_cast<void>(::pwrite(lock.file_, text, static_cast<std::size_t>(size), 0) == size);
  return lock;
}

StateLock::~StateLock() {
  for (const int fd : {file_, folder_})
    if (fd >= 0) ::close(fd);
}

std::vector<std::string> machine_keys(const LinkSpec& link) {
  if (link.place.starts_with('/')) {
    struct stat status {};
    if (::stat(link.place.c_str(), &status) == 0 && S_ISCHR(status.st_mode))
      return {"device " + std::to_string(major(status.st_rdev)) + ":" +
              std::to_string(minor(status.st_rdev))};
    std::error_code none;
    const auto path = std::filesystem::weakly_canonical(link.place, none);
    return {"device " + (none ? link.place : path.string())};
  }
  const std::string at = ":" + std::to_string(link.port) + "/" + std::to_string(link.unit);
  std::string name = link.place;
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  // This name is the loopback whatever the resolver knows (RFC 6761, 6.3); without /etc/hosts it knows
  // nothing.
  if (name == "localhost") name = "127.0.0.1";
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (::getaddrinfo(name.c_str(), nullptr, &hints, &found) != 0) return {name + at};
  std::set<std::string> keys;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next)
    if (one->ai_family == AF_INET || one->ai_family == AF_INET6) {
      const std::string host = address_text(*one);
      keys.insert(host + at);
      if (link.kind == LinkKind::kGrbl && host != kOwn)
        keys.insert(host + (link.carrier == Carrier::kWebSocket ? kSocketWay : kPlainWay) + at);
    }
  ::freeaddrinfo(found);
  return {keys.begin(), keys.end()};
}

MachineClaim::~MachineClaim() {
  for (const auto& [key, fd] : held_) ::close(fd);
}

Result<void> MachineClaim::follow(const LinkSpec& link) {
  const std::vector<std::string> keys = machine_keys(link);
  std::map<std::string, int> taken;
  for (const std::string& key : keys) {
    if (held_.contains(key)) continue;
    const Result<int> fd = claim(key, link);
    if (!fd) {
      for (const auto& [own, socket] : taken) ::close(socket);
      return tl::unexpected<Error>(fd.error());
    }
    taken[key] = *fd;
  }
  // Claimed first and looked second: of two who come at once none has it, or one.
  if (const std::string other = claimed_the_other_way(keys, held_); !other.empty()) {
    for (const auto& [own, socket] : taken) ::close(socket);
    return fail(Code::kUsage, describe(link) + " leads to a board (" + other + ") that " + holder_of(other) +
                                  " serves already: one service a machine, by whichever way");
  }
  std::erase_if(held_, [&](const auto& one) {
    if (std::find(keys.begin(), keys.end(), one.first) != keys.end()) return false;
    ::close(one.second);
    return true;
  });
  held_.merge(taken);
  return {};
}

void MachineClaim::turn_away() const {
  for (const auto& [key, fd] : held_)
    for (int asking = -1; (asking = ::accept4(fd, nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) ::close(asking);
}

}  // namespace tiltfeed::daemon
