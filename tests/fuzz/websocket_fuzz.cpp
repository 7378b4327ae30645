// What a WebSocket server says: any bytes. However they are cut, the stream is the same, no longer than the
// bytes, and nothing follows a broken rule or a close.

#include "daemon/wire/websocket.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::daemon;

FUZZ_TARGET(websocket) {
  for (const bool binary_only : {false, true}) {
    WebSocketReader whole(binary_only), cut(binary_only);
    std::string stream, pieces, ping;
    const bool fine = whole.take(bytes, stream).has_value();
    bool still = true;
    for (std::size_t at = 0; at < bytes.size(); at += 3)
      still = cut.take(bytes.substr(at, 3), pieces).has_value();
    HOLDS(fine == still || bytes.empty());
    HOLDS(stream == pieces && stream.size() <= bytes.size());
    HOLDS(whole.closed() == cut.closed() && whole.close_reason() == cut.close_reason());
    if (whole.take_ping(ping)) HOLDS(ping.size() <= 125);
    if (!fine || whole.closed()) {
      static_cast<void>(whole.take("\x82\x01x", stream));
      HOLDS(stream == pieces);
    }
  }
  static_cast<void>(read_websocket_answer(bytes, "dGhlIHNhbXBsZSBub25jZQ=="));
}
