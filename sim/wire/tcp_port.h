#pragma once
// The machine's end of a TCP wire: one host at a time, which may come and go.

#include <string>
#include <utility>

#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

class TcpPort {
 public:
  /// Listens on "ADDRESS:PORT", a numeric IPv4 address; port 0 takes a free one. Errors: kUsage, kIo.
  static Result<TcpPort> open(const std::string& place);

  TcpPort(TcpPort&& other) noexcept
      : listener_(std::exchange(other.listener_, -1)),
        host_(std::exchange(other.host_, -1)),
        place_(std::move(other.place_)) {}
  TcpPort(const TcpPort&) = delete;
  TcpPort& operator=(const TcpPort&) = delete;
  TcpPort& operator=(TcpPort&&) = delete;
  ~TcpPort();

  /// What becomes readable: the host's bytes, or a host that comes.
  int master() const { return host_ >= 0 ? host_ : listener_; }
  /// True when a host has come now: then there is nothing to read yet.
  bool welcome();
  /// The host has gone.
  void part();
  bool connected() const { return host_ >= 0; }
  const std::string& device() const { return place_; }  ///< the address, with the port that was taken

 private:
  TcpPort() = default;
  int listener_ = -1, host_ = -1;
  std::string place_;
};

}  // namespace tiltfeed::sim
