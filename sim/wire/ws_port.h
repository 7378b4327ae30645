#pragma once
// The machine's end of a WebSocket (RFC 6455), as network boards have it: over a TCP port, one host at a
// time. It shares nothing with the client that it is to test.

#include <cstdint>
#include <string>
#include <string_view>

#include "sim/wire/tcp_port.h"

namespace tiltfeed::sim {

class WsPort {
 public:
  static Result<WsPort> open(const std::string& place);

  int master() const { return port_.master(); }
  bool welcome();
  void part();
  bool connected() const { return port_.connected(); }
  const std::string& device() const { return port_.device(); }

  /// What the host's bytes say to the machine. A host that breaks the protocol, or closes, is to be parted
  /// with: leaves() says so.
  std::string decode(std::string_view bytes);
  /// What the machine says, as frames: now and then in pieces, with pings and messages for web pages between
  /// them, as real boards have them. Before the opening is done it is kept.
  std::string encode(std::string_view text);
  bool leaves() const { return leaves_; }

 private:
  explicit WsPort(TcpPort&& port) : port_(std::move(port)) {}
  void open_session();
  void take_frames(std::string& said);

  TcpPort port_;
  std::string in_, out_, kept_;  ///< of the host, to the host, of the machine before the opening is done
  bool open_ = false, leaves_ = false, binary_ = false;
  std::uint64_t messages_ = 0;
};

}  // namespace tiltfeed::sim
