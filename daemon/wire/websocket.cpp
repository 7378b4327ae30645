#include "daemon/wire/websocket.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <vector>

#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";  // RFC 6455, 1.3
constexpr std::size_t kMostControl = 125;
constexpr std::uint8_t kLast = 0x80, kReserved = 0x70, kMasked = 0x80, kShort = 125, kWords = 126;

/// FIPS 180-4. Not for secrets: the handshake wants it.
std::array<std::uint8_t, 20> sha1(std::string_view text) {
  std::array<std::uint32_t, 5> h{0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
  std::string data(text);
  data += '\x80';
  while (data.size() % 64 != 56) data += '\0';
  for (int shift = 56; shift >= 0; shift -= 8)
    data += static_cast<char>(static_cast<std::uint64_t>(text.size()) * 8 >> shift);
  for (std::size_t at = 0; at < data.size(); at += 64) {
    std::array<std::uint32_t, 80> w{};
    for (std::size_t i = 0; i < 64; ++i) w[i / 4] = w[i / 4] << 8 | static_cast<std::uint8_t>(data[at + i]);
    for (std::size_t i = 16; i < 80; ++i) w[i] = std::rotl(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
    auto [a, b, c, d, e] = h;
    for (std::size_t i = 0; i < 80; ++i) {
      const std::uint32_t f = i < 20              ? (b & c) | (~b & d)
                              : i < 40 || i >= 60 ? b ^ c ^ d
                                                  : (b & c) | (b & d) | (c & d);
      const std::uint32_t k = i < 20 ? 0x5A827999 : i < 40 ? 0x6ED9EBA1 : i < 60 ? 0x8F1BBCDC : 0xCA62C1D6;
      const std::uint32_t t = std::rotl(a, 5) + f + e + k + w[i];
      e = d, d = c, c = std::rotl(b, 30), b = a, a = t;
    }
    h[0] += a, h[1] += b, h[2] += c, h[3] += d, h[4] += e;
  }
  std::array<std::uint8_t, 20> digest{};
  for (std::size_t i = 0; i < digest.size(); ++i)
    digest[i] = static_cast<std::uint8_t>(h[i / 4] >> (24 - i % 4 * 8));
  return digest;
}

template <class Bytes>
std::string base64(const Bytes& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 3; ++i) word = word << 8 | (at + i < bytes.size() ? bytes[at + i] : 0U);
    for (std::size_t i = 0; i < 4; ++i)
      text += at + i <= bytes.size() ? kDigits[word >> (18 - 6 * i) & 63] : '=';
  }
  return text;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  while (text.ends_with(' ') || text.ends_with('\t') || text.ends_with('\r')) text.remove_suffix(1);
  return text;
}

/// The value of a header; empty: it is not there.
std::string_view header_of(std::string_view head, std::string_view name) {
  while (!head.empty()) {
    const std::string_view line = head.substr(0, head.find('\n'));
    head.remove_prefix(std::min(line.size() + 1, head.size()));
    const std::size_t colon = line.find(':');
    if (colon != line.npos && lower(line.substr(0, colon)) == name) return trimmed(line.substr(colon + 1));
  }
  return {};
}

}  // namespace

std::string websocket_key(const std::array<std::uint8_t, 16>& bytes) { return base64(bytes); }
std::string websocket_accept(std::string_view key) {
  return base64(sha1(std::string(key) + std::string(kGuid)));
}

std::string websocket_request(std::string_view host, std::string_view path, std::string_view key) {
  return "GET " + std::string(path) + " HTTP/1.1\r\nHost: " + std::string(host) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: " + std::string(key) +
         "\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: arduino\r\n\r\n";
}

Result<bool> read_websocket_answer(std::string_view head, std::string_view key) {
  const std::string first = wire_text(trimmed(head.substr(0, head.find('\n'))).substr(0, 80));
  if (!head.starts_with("HTTP/1.1 101"))
    return fail(Code::kLink, "no WebSocket is spoken there: it answers '" + first + "'; check port and path");
  if (lower(header_of(head, "upgrade")) != "websocket" ||
      lower(header_of(head, "connection")).find("upgrade") == std::string::npos ||
      header_of(head, "sec-websocket-accept") != websocket_accept(key))
    return fail(Code::kLink, "the answer to the WebSocket's opening does not belong to it (RFC 6455, 4.1)");
  const std::string_view protocol = header_of(head, "sec-websocket-protocol");
  if (!protocol.empty() && protocol != "arduino")
    return fail(Code::kLink, "the board chose the subprotocol '" + wire_text(protocol.substr(0, 40)) +
                                 "', which was not offered");
  if (!header_of(head, "sec-websocket-extensions").empty())
    return fail(Code::kLink, "the board chose a WebSocket extension, and none was offered");
  return !protocol.empty();
}

std::string websocket_frame(WebSocketOp op, std::string_view payload,
                            const std::array<std::uint8_t, 4>& mask) {
  assert(payload.size() <= 65535);
  assert(op < WebSocketOp::kClose || payload.size() <= kMostControl);
  std::string frame(1, static_cast<char>(kLast | static_cast<std::uint8_t>(op)));
  if (payload.size() <= kShort) {
    frame += static_cast<char>(kMasked | payload.size());
  } else {
    frame += static_cast<char>(kMasked | kWords);
    frame += static_cast<char>(payload.size() >> 8);
    frame += static_cast<char>(payload.size() & 0xFF);
  }
  for (const std::uint8_t one : mask) frame += static_cast<char>(one);
  for (std::size_t i = 0; i < payload.size(); ++i)
    frame += static_cast<char>(static_cast<std::uint8_t>(payload[i]) ^ mask[i % mask.size()]);
  return frame;
}

tl::unexpected<Error> WebSocketReader::broken(const std::string& what) {
  broken_ = true;
  wrong_ = "the board breaks the WebSocket protocol: " + what;
  return fail(Code::kLink, wrong_);
}

/// Called with each byte of a header that has come, until it is whole.
Result<void> WebSocketReader::take_header() {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(header_[i]); };
  if (header_.size() < 2) return {};
  const auto op = static_cast<WebSocketOp>(byte(0) & 0x0F);
  const bool control = op >= WebSocketOp::kClose, last = (byte(0) & kLast) != 0;
  if ((byte(0) & kReserved) != 0) return broken("reserved bits are set");
  if ((op > WebSocketOp::kBinary && !control) || op > WebSocketOp::kPong)
    return broken("an unknown kind of frame");
  if ((byte(1) & kMasked) != 0) return broken("a server's frame is masked");
  const std::uint8_t size = byte(1) & 0x7F;
  if (control && (!last || size > kShort)) return broken("a control frame is long or in pieces");
  if (!control && (op == WebSocketOp::kMore) != (message_ != WebSocketOp::kMore))
    return broken(op == WebSocketOp::kMore ? "a piece of no message" : "a message inside another");
  const std::size_t more = size <= kShort ? 0 : size == kWords ? 2 : 8;
  if (header_.size() < 2 + more) return {};
  left_ = size;
  if (more > 0) left_ = 0;
  for (std::size_t i = 0; i < more; ++i) left_ = left_ << 8 | byte(2 + i);
  if (left_ >> 63 != 0) return broken("the length of a frame");
  op_ = op;
  last_ = last;
  if (!control && op != WebSocketOp::kMore) message_ = op;
  in_frame_ = true;
  control_.clear();
  header_.clear();
  return {};
}

void WebSocketReader::end_of_frame() {
  in_frame_ = false;
  if (op_ == WebSocketOp::kPing) {
    ping_ = control_;
    pinged_ = true;
  } else if (op_ == WebSocketOp::kClose) {
    closed_ = true;
    if (control_.size() >= 2) {
      const int code = static_cast<std::uint8_t>(control_[0]) << 8 | static_cast<std::uint8_t>(control_[1]);
      reason_ = std::to_string(code) + (control_.size() > 2 ? ", " + wire_text(control_.substr(2)) : "");
    }
  } else if (op_ < WebSocketOp::kClose && last_) {
    message_ = WebSocketOp::kMore;
  }
}

Result<void> WebSocketReader::take(std::string_view bytes, std::string& stream) {
  if (broken_) return fail(Code::kLink, wrong_);
  while (!bytes.empty() && !closed_) {
    if (!in_frame_) {
      header_ += bytes.front();
      bytes.remove_prefix(1);
      if (const Result<void> fine = take_header(); !fine) return fine;
    } else {
      const std::string_view some =
          bytes.substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(left_, bytes.size())));
      bytes.remove_prefix(some.size());
      left_ -= some.size();
      if (op_ >= WebSocketOp::kClose)
        control_ += some;
      else if (message_ == WebSocketOp::kBinary || !binary_only_)
        stream += some;
    }
    if (in_frame_ && left_ == 0) end_of_frame();
  }
  return {};
}

bool WebSocketReader::take_ping(std::string& payload) {
  if (!pinged_) return false;
  pinged_ = false;
  payload = std::move(ping_);
  ping_.clear();
  return true;
}

}  // namespace tiltfeed::daemon
