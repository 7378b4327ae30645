#include "sim/wire/ws_port.h"

#include <array>
#include <cctype>

namespace tiltfeed::sim {
namespace {

constexpr int kMore = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10;
/// Every so many messages one comes in pieces, a ping, a message for web pages.
constexpr std::uint64_t kPieces = 3, kPings = 7, kPages = 11;

std::uint32_t turned(std::uint32_t word, int by) { return word << by | word >> (32 - by); }

std::string digest(std::string text) {
  const std::uint64_t bits = text.size() * 8;
  text.push_back('\x80');
  text.resize((text.size() + 8 + 63) / 64 * 64 - 8, '\0');
  for (int i = 7; i >= 0; --i) text.push_back(static_cast<char>(bits >> (8 * i)));
  std::uint32_t state[5] = {0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
  for (std::size_t block = 0; block < text.size(); block += 64) {
    std::uint32_t words[80];
    for (std::size_t t = 0; t < 80; ++t) {
      if (t >= 16) {
        words[t] = turned(words[t - 3] ^ words[t - 8] ^ words[t - 14] ^ words[t - 16], 1);
        continue;
      }
      words[t] = 0;
      for (std::size_t k = 0; k < 4; ++k)
        words[t] = words[t] * 256 + static_cast<unsigned char>(text[block + 4 * t + k]);
    }
    std::uint32_t v[5];
    for (int i = 0; i < 5; ++i) v[i] = state[i];
    for (std::size_t t = 0; t < 80; ++t) {
      std::uint32_t mix = v[1] ^ v[2] ^ v[3], constant = t < 40 ? 0x6ED9EBA1 : 0xCA62C1D6;
      if (t < 20) mix = (v[1] & v[2]) | (~v[1] & v[3]), constant = 0x5A827999;
      if (t >= 40 && t < 60) mix = (v[1] & v[2]) | (v[1] & v[3]) | (v[2] & v[3]), constant = 0x8F1BBCDC;
      const std::uint32_t next = turned(v[0], 5) + mix + v[4] + words[t] + constant;
      v[4] = v[3], v[3] = v[2], v[2] = turned(v[1], 30), v[1] = v[0], v[0] = next;
    }
    for (int i = 0; i < 5; ++i) state[i] += v[i];
  }
  std::string bytes;
  for (const std::uint32_t word : state)
    for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(word >> shift));
  return bytes;
}

std::string in_base64(const std::string& bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  int bits = 0, waiting = 0;
  for (const char c : bytes) {
    bits = (bits << 8 | static_cast<unsigned char>(c)) & 0xFFFF, waiting += 8;
    for (; waiting >= 6; waiting -= 6) text += digits[static_cast<std::size_t>(bits >> (waiting - 6) & 63)];
  }
  if (waiting > 0) text += digits[static_cast<std::size_t>(bits << (6 - waiting) & 63)];
  while (text.size() % 4 != 0) text += '=';
  return text;
}

std::string frame(int op, bool last, std::string_view payload) {
  std::string bytes{static_cast<char>(op | (last ? 0x80 : 0))};
  if (payload.size() < 126) {
    bytes += static_cast<char>(payload.size());
  } else if (payload.size() < 65536) {
    bytes += {126, static_cast<char>(payload.size() >> 8), static_cast<char>(payload.size())};
  } else {
    bytes += 127;
    for (int i = 7; i >= 0; --i)
      bytes += static_cast<char>(static_cast<std::uint64_t>(payload.size()) >> (8 * i));
  }
  return bytes.append(payload);
}

/// The value of a line of the request, whatever the case of its name.
std::string value_of(const std::string& head, const std::string& name) {
  for (std::size_t at = 0; (at = head.find('\n', at)) != head.npos;) {
    ++at;
    std::size_t i = 0;
    while (i < name.size() && at + i < head.size() &&
           std::tolower(static_cast<unsigned char>(head[at + i])) == name[i])
      ++i;
    if (i < name.size() || head[at + i] != ':') continue;
    const std::size_t from = head.find_first_not_of(' ', at + i + 1);
    return head.substr(from, head.find('\r', from) - from);
  }
  return "";
}

}  // namespace

Result<WsPort> WsPort::open(const std::string& place) {
  Result<TcpPort> port = TcpPort::open(place);
  if (!port) return tl::unexpected<Error>(port.error());
  return WsPort(std::move(*port));
}

bool WsPort::welcome() {
  const bool came = port_.welcome();
  if (came) {
    in_.clear(), out_.clear(), kept_.clear();
    open_ = leaves_ = false;
    messages_ = 0;
  }
  return came;
}

void WsPort::part() {
  port_.part();
  leaves_ = false;
}

void WsPort::open_session() {
  const std::size_t end = in_.find("\r\n\r\n");
  if (end == in_.npos) return;
  const std::string head = in_.substr(0, end + 2), key = value_of(head, "sec-websocket-key");
  in_.erase(0, end + 4);
  if (!head.starts_with("GET /") || key.size() != 24 || value_of(head, "sec-websocket-version") != "13") {
    out_ += "HTTP/1.1 400 Bad Request\r\n\r\n";
    leaves_ = true;
    return;
  }
  binary_ = value_of(head, "sec-websocket-protocol") == "arduino";
  out_ +=
      "HTTP/1.1 101 Switching Protocols\r\nupgrade: WebSocket\r\nconnection: keep-alive, Upgrade\r\n"
      "sec-websocket-accept: " +
      in_base64(digest(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11")) +
      (binary_ ? "\r\nsec-websocket-protocol: arduino\r\n\r\n" : "\r\n\r\n");
  open_ = true;
  if (binary_) out_ += frame(kText, true, "CURRENT_ID:0");
}

std::string WsPort::decode(std::string_view bytes) {
  in_ += bytes;
  std::string said;
  if (!open_ && !leaves_) open_session();
  if (open_) take_frames(said);
  return said;
}

/// Whole frames only. A host's frames are masked.
void WsPort::take_frames(std::string& said) {
  while (in_.size() >= 2 && !leaves_) {
    const auto byte = [&](std::size_t i) {
      return static_cast<std::size_t>(static_cast<unsigned char>(in_[i]));
    };
    const std::size_t form = byte(1) & 127, extra = form == 126 ? 2 : form == 127 ? 8 : 0;
    if ((byte(1) & 128) == 0 || (byte(0) & 0x70) != 0) {
      leaves_ = true;
      return;
    }
    if (in_.size() < 6 + extra) return;
    std::size_t size = extra == 0 ? form : 0;
    for (std::size_t i = 0; i < extra; ++i) size = size * 256 + byte(2 + i);
    if (in_.size() < 6 + extra + size) return;
    std::string payload = in_.substr(6 + extra, size);
    for (std::size_t i = 0; i < size; ++i)
      payload[i] = static_cast<char>(payload[i] ^ in_[2 + extra + i % 4]);
    const int op = static_cast<int>(byte(0) & 15);
    in_.erase(0, 6 + extra + size);
    if (op == kMore || op == kText || op == kBinary) said += payload;
    if (op == kPing) out_ += frame(kPong, true, payload);
    if (op == kClose) out_ += frame(kClose, true, payload), leaves_ = true;
  }
}

std::string WsPort::encode(std::string_view text) {
  kept_ += text;
  if (open_ && !kept_.empty()) {
    ++messages_;
    const int op = binary_ ? kBinary : kText;
    const std::size_t half = kept_.size() / 2;
    if (messages_ % kPieces == 0) {
      out_ += frame(op, false, std::string_view(kept_).substr(0, half));
      if (messages_ % kPings == 0)
        out_ += frame(kPing, true, "Hi");  // control frames may come between pieces
      out_ += frame(kMore, true, std::string_view(kept_).substr(half));
    } else {
      out_ += frame(op, true, kept_);
      if (messages_ % kPings == 0) out_ += frame(kPing, true, "");
    }
    if (binary_ && messages_ % kPages == 0) out_ += frame(kText, true, "PING:0");
    kept_.clear();
  }
  return std::exchange(out_, {});
}

}  // namespace tiltfeed::sim
