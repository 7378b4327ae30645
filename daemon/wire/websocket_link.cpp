#include "daemon/wire/websocket_link.h"

#include <sys/random.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "daemon/wire/steady_clock.h"
#include "daemon/wire/tcp_link.h"
#include "daemon/wire/websocket.h"

namespace tiltfeed::daemon {

namespace {

constexpr Time kOpenTime = std::chrono::seconds(5);
/// Of the stream in one frame: a hold that comes next does not wait behind much.
constexpr std::size_t kMostInFrame = 1024;
constexpr std::string_view kNormalClose = "\x03\xE8";  // 1000

template <std::size_t size>
std::array<std::uint8_t, size> random_bytes() {
  std::array<std::uint8_t, size> bytes{};
  // So few bytes come whole once the system has booted.
  const ssize_t got = ::getrandom(bytes.data(), bytes.size(), 0);
  assert(got == static_cast<ssize_t>(bytes.size()));
  static_cast<void>(got);
  return bytes;
}

std::string frame(WebSocketOp op, std::string_view payload) {
  return websocket_frame(op, payload, random_bytes<4>());
}

class WebSocketLink : public Link {
 public:
  WebSocketLink(std::unique_ptr<Link> tcp, std::string name) : tcp_(std::move(tcp)), name_(std::move(name)) {}
  /// A board serves one client only: it is told at once that this one goes.
  ~WebSocketLink() override {
    if (!opened_ || !lost_.empty()) return;
    out_ += frame(WebSocketOp::kClose, kNormalClose);
    std::string in;
    static_cast<void>(tcp_->exchange(out_, Time::zero(), in));
  }

  Result<void> open(const LinkSpec& link) {
    const std::string key = websocket_key(random_bytes<16>());
    const std::string host = link.place.find(':') == link.place.npos ? link.place : "[" + link.place + "]";
    out_ = websocket_request(host + ":" + std::to_string(link.port), link.path, key);
    SteadyClock clock;
    std::string head;
    for (const Time end = clock.now() + kOpenTime; clock.now() < end && head.size() < kMostWebSocketHead;) {
      const auto taken = tcp_->exchange(out_, end - clock.now(), head);
      if (!taken)
        return fail(Code::kLink, name_ + ": closed instead of opening a WebSocket; check port and path");
      out_.erase(0, *taken);
      const std::size_t rest = head.find("\r\n\r\n");
      if (rest == head.npos) continue;
      const Result<bool> agreed = read_websocket_answer(std::string_view(head).substr(0, rest + 2), key);
      if (!agreed) return fail(Code::kLink, name_ + ": " + agreed.error().message);
      reader_ = WebSocketReader(*agreed);
      opened_ = true;
      receive(std::string_view(head).substr(rest + 4), early_);
      return {};
    }
    return fail(Code::kLink, name_ + ": no answer to the opening of a WebSocket; check port and path");
  }

  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    const std::size_t before = in.size();
    in += early_;
    if (!std::exchange(early_, {}).empty()) wait = Time::zero();
    if (!lost_.empty()) return in.size() > before ? Result<std::size_t>(0) : gone();
    // A frame that has begun goes out whole. What is taken here may be executed, whatever comes after.
    const bool fresh = out_.empty();
    std::size_t taken = 0;
    if (fresh) {
      std::string ping;
      if (reader_.take_ping(ping)) out_ = frame(WebSocketOp::kPong, ping);
      if (out_.empty() && !out.empty()) {
        taken = std::min(out.size(), kMostInFrame);
        out_ = frame(WebSocketOp::kBinary, out.substr(0, taken));
      }
    }
    std::string raw;
    const auto sent = tcp_->exchange(out_, wait, raw);
    if (!sent) return lost_ = sent.error().message, gone();
    if (taken > 0 && *sent == 0) {
      taken = 0;  // not begun: something more urgent may come first
      out_.clear();
    }
    out_.erase(0, *sent);
    receive(raw, in);
    if (!lost_.empty() && taken == 0 && in.size() == before) return gone();
    return taken;
  }

 private:
  void receive(std::string_view raw, std::string& in) {
    if (const Result<void> fine = reader_.take(raw, in); !fine) lost_ = name_ + ": " + fine.error().message;
    if (lost_.empty() && reader_.closed())
      lost_ = name_ + ": connection lost: the board has closed the WebSocket" +
              (reader_.close_reason().empty() ? "" : " (" + reader_.close_reason() + ")") +
              "; check whether another program or a browser has connected to it";
  }
  tl::unexpected<Error> gone() const { return fail(Code::kLink, lost_); }

  std::unique_ptr<Link> tcp_;
  std::string name_, out_, early_, lost_;
  WebSocketReader reader_{false};
  bool opened_ = false;
};

}  // namespace

Result<std::unique_ptr<Link>> open_websocket_link(const LinkSpec& link) {
  Result<std::unique_ptr<Link>> tcp = open_tcp_link(link);
  if (!tcp) return tcp;
  auto made = std::make_unique<WebSocketLink>(std::move(*tcp), describe(link));
  if (const Result<void> opened = made->open(link); !opened) return tl::unexpected<Error>(opened.error());
  return made;
}

}  // namespace tiltfeed::daemon
