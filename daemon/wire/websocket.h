#pragma once
// The client's end of a WebSocket (RFC 6455), as bytes: the opening handshake and the frames. No I/O. A
// stream of bytes goes over it in binary messages; how it is cut into messages and frames means nothing.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Sec-WebSocket-Key of 16 bytes, and what a server has to answer to it.
std::string websocket_key(const std::array<std::uint8_t, 16>& bytes);
std::string websocket_accept(std::string_view key);

/// The request; `host` with its port. It offers the subprotocol "arduino": boards that know it put the stream
/// into binary messages, and what is for their web pages into text messages.
std::string websocket_request(std::string_view host, std::string_view path, std::string_view key);
/// What a server has said to it, up to the empty line. True: it agreed to "arduino". Errors: kLink with what
/// it said instead.
Result<bool> read_websocket_answer(std::string_view head, std::string_view key);
inline constexpr std::size_t kMostWebSocketHead = 8192;

enum class WebSocketOp : std::uint8_t {
  kMore = 0,
  kText = 1,
  kBinary = 2,
  kClose = 8,
  kPing = 9,
  kPong = 10
};

/// A whole frame from a client: masked. Requires: at most 65535 bytes; 125 in a control frame.
std::string websocket_frame(WebSocketOp op, std::string_view payload,
                            const std::array<std::uint8_t, 4>& mask);

/// Takes a server's frames apart, in whatever pieces they come. Properties: the pieces do not matter; a ping
/// is answered once, with its own payload; nothing is taken after a close or a broken rule.
class WebSocketReader {
 public:
  /// `binary_only`: text messages are for others, and dropped.
  explicit WebSocketReader(bool binary_only) : binary_only_(binary_only) {}

  /// Appends what is of the stream to `stream`. Errors: kLink: the server broke the protocol; so do all that
  /// follow.
  Result<void> take(std::string_view bytes, std::string& stream);
  /// Payloads that pongs have to carry back, since the last call; the newest only, as the protocol allows.
  bool take_ping(std::string& payload);
  bool closed() const { return closed_; }
  /// "1001, going away"; empty: it gave no reason.
  const std::string& close_reason() const { return reason_; }

 private:
  Result<void> take_header();
  void end_of_frame();
  tl::unexpected<Error> broken(const std::string& what);

  bool binary_only_, broken_ = false, closed_ = false, pinged_ = false;
  std::string header_, control_, ping_, reason_, wrong_;
  WebSocketOp op_ = WebSocketOp::kMore, message_ = WebSocketOp::kMore;  // of the frame; of the open message
  bool in_frame_ = false, last_ = true;
  std::uint64_t left_ = 0;  // payload bytes of the frame still to come
};

}  // namespace tiltfeed::daemon
