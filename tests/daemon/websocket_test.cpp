// Frames and handshake of a WebSocket client, held to the examples of RFC 6455 and to a server of ten lines.

#include "daemon/wire/websocket.h"

#include <gtest/gtest.h>

#include <random>

namespace tiltfeed {
using namespace daemon;
namespace {

std::string bytes(std::initializer_list<int> list) {
  std::string text;
  for (const int one : list) text += static_cast<char>(one);
  return text;
}

/// As a server would send it: not masked.
std::string served(int first, std::string_view payload) {
  std::string frame(1, static_cast<char>(first));
  const std::size_t size = payload.size();
  if (size < 126)
    frame += static_cast<char>(size);
  else if (size < 65536)
    frame += bytes({126, static_cast<int>(size >> 8), static_cast<int>(size & 255)});
  else
    frame += bytes({127, 0, 0, 0, 0, static_cast<int>(size >> 24), static_cast<int>(size >> 16 & 255),
                    static_cast<int>(size >> 8 & 255), static_cast<int>(size & 255)});
  return frame.append(payload);
}

TEST(WebSocket, ExamplesOfTheStandard) {
  EXPECT_EQ(websocket_accept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");  // 1.3
  std::array<std::uint8_t, 16> one_to_sixteen{};
  for (std::uint8_t i = 0; i < 16; ++i) one_to_sixteen[i] = static_cast<std::uint8_t>(i + 1);
  EXPECT_EQ(websocket_key(one_to_sixteen), "AQIDBAUGBwgJCgsMDQ4PEA==");  // 4.1
  EXPECT_EQ(websocket_frame(WebSocketOp::kText, "Hello", {0x37, 0xfa, 0x21, 0x3d}),
            bytes({0x81, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58}));  // 5.7
  for (const std::string& frames : {bytes({0x81, 0x05, 0x48, 0x65, 0x6c, 0x6c, 0x6f}),
                                    bytes({0x01, 0x03, 0x48, 0x65, 0x6c, 0x80, 0x02, 0x6c, 0x6f})}) {
    WebSocketReader reader(false);
    std::string stream;
    ASSERT_TRUE(reader.take(frames, stream));
    EXPECT_EQ(stream, "Hello");
  }
  WebSocketReader reader(false);
  std::string stream, ping;
  ASSERT_TRUE(reader.take(bytes({0x89, 0x05, 0x48, 0x65, 0x6c, 0x6c, 0x6f}), stream));
  ASSERT_TRUE(reader.take_ping(ping));
  EXPECT_EQ(ping, "Hello");
  EXPECT_FALSE(reader.take_ping(ping)) << "answered once";
  EXPECT_EQ(websocket_frame(WebSocketOp::kPong, ping, {0x37, 0xfa, 0x21, 0x3d}),
            bytes({0x8a, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58}));
  ASSERT_TRUE(reader.take(bytes({0x82, 0x7E, 0x01, 0x00}) + std::string(256, 'x'), stream));
  EXPECT_EQ(stream, std::string(256, 'x'));
}

TEST(WebSocket, AMaskedFrameComesBackWhateverItsLength) {
  const std::array<std::uint8_t, 4> mask{0x00, 0xff, 0x5a, 0x81};
  for (const std::size_t size : {0, 1, 3, 125, 126, 127, 1024, 65535}) {
    std::string payload;
    for (std::size_t i = 0; i < size; ++i) payload += static_cast<char>(i * 7);
    const std::string frame = websocket_frame(WebSocketOp::kBinary, payload, mask);
    const std::size_t head = size < 126 ? 2 : 4;
    ASSERT_EQ(frame.size(), head + 4 + size);
    EXPECT_EQ(static_cast<unsigned char>(frame[0]), 0x82);
    EXPECT_EQ(static_cast<unsigned char>(frame[1]), 0x80 | (size < 126 ? size : 126));
    std::string back = frame.substr(head + 4);
    for (std::size_t i = 0; i < size; ++i) back[i] = static_cast<char>(back[i] ^ frame[head + i % 4]);
    EXPECT_EQ(back, payload);
  }
}

struct Piece {
  bool text = false, last = true;
  std::string payload;
  bool ping = false;
};

/// Random streams in random messages and frames, with control frames anywhere between, in random pieces.
TEST(WebSocket, TheStreamIsTheSameHoweverItIsCut) {
  std::mt19937 random(20);
  const auto below = [&](std::size_t n) { return random() % n; };
  for (int run = 0; run < 300; ++run) {
    const bool binary_only = below(2) == 0;
    std::string wire, meant, pings;
    std::vector<Piece> pieces;
    bool ping_sent = false;
    for (std::size_t messages = 1 + below(12); messages > 0; --messages) {
      const bool text = below(4) == 0;
      for (std::size_t frames = 1 + below(4); frames > 0; --frames) {
        std::string payload;
        for (std::size_t i = below(run % 10 == 0 ? 70000 : 300); i > 0; --i)
          payload += static_cast<char>(random());
        if (!text || !binary_only) meant += payload;
        pieces.push_back({text, frames == 1, payload});
        if (below(5) == 0) pieces.push_back({false, true, std::string(below(126), 'p'), true});
      }
    }
    bool open = false;
    for (const Piece& one : pieces) {
      if (one.ping) {
        wire += served(0x89, one.payload);
        pings = one.payload;
        ping_sent = true;
        continue;
      }
      wire += served((one.last ? 0x80 : 0) | (open ? 0 : one.text ? 1 : 2), one.payload);
      open = !one.last;
    }
    WebSocketReader reader(binary_only);
    std::string stream;
    for (std::size_t at = 0; at < wire.size();) {
      const std::size_t count = std::min(wire.size() - at, 1 + below(run % 3 == 0 ? 3 : 5000));
      ASSERT_TRUE(reader.take(std::string_view(wire).substr(at, count), stream));
      at += count;
    }
    ASSERT_EQ(stream, meant) << run;
    std::string ping;
    EXPECT_EQ(reader.take_ping(ping), ping_sent);
    EXPECT_EQ(ping, pings);
  }
}

TEST(WebSocket, ACloseEndsTheStreamWithItsReason) {
  WebSocketReader reader(false);
  std::string stream;
  ASSERT_TRUE(reader.take(
      served(0x82, "ok\n") + served(0x88, bytes({0x03, 0xE9}) + "going") + served(0x82, "no"), stream));
  EXPECT_TRUE(reader.closed());
  EXPECT_EQ(reader.close_reason(), "1001, going");
  EXPECT_EQ(stream, "ok\n");
  WebSocketReader silent(false);
  ASSERT_TRUE(silent.take(served(0x88, ""), stream));
  EXPECT_TRUE(silent.closed());
  EXPECT_EQ(silent.close_reason(), "");
}

/// Lengths around those at which a frame's header changes, whole and byte by byte.
TEST(WebSocket, AFrameOfAnyLengthIsTakenInAnyPieces) {
  for (const std::size_t size : {0, 1, 125, 126, 127, 65535, 65536, 65537, 200000})
    for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{65536}, size + 20}) {
      std::string payload;
      for (std::size_t i = 0; i < size; ++i) payload += static_cast<char>('a' + i % 23);
      const std::string wire = served(0x82, payload) + served(0x82, "ok\n");
      WebSocketReader reader(false);
      std::string stream;
      for (std::size_t at = 0; at < wire.size(); at += piece)
        ASSERT_TRUE(reader.take(std::string_view(wire).substr(at, piece), stream)) << size;
      ASSERT_EQ(stream, payload + "ok\n") << size << " in pieces of " << piece;
    }
}

/// What came before belongs to the stream, nothing that comes after does.
TEST(WebSocket, ACloseInTheMiddleOfAMessageEndsTheStreamThere) {
  const std::string close = served(0x88, bytes({0x03, 0xE8})), ping = served(0x89, "p");
  WebSocketReader reader(false);
  std::string stream, pinged;
  ASSERT_TRUE(
      reader.take(served(0x02, "o") + ping + served(0x00, "k\n") + close + served(0x80, "ok\n"), stream));
  EXPECT_TRUE(reader.closed());
  EXPECT_EQ(reader.close_reason(), "1000");
  EXPECT_EQ(stream, "ok\n");
  EXPECT_TRUE(reader.take_ping(pinged));
  ASSERT_TRUE(reader.take(served(0x82, "ok\n"), stream)) << "no error, and nothing is taken";
  EXPECT_EQ(stream, "ok\n");
  // Inside a frame there is no place for one: its bytes are of the payload.
  WebSocketReader inside(false);
  const std::string whole = served(0x82, "ab" + close);
  stream.clear();
  ASSERT_TRUE(inside.take(whole, stream));
  EXPECT_FALSE(inside.closed());
  EXPECT_EQ(stream, "ab" + close);
}

TEST(WebSocket, AMaskedFrameAmongOthersIsABrokenRule) {
  const std::string masked = bytes({0x80, 0x83, 0, 0, 0, 0, 'o', 'k', '\n'});
  WebSocketReader reader(false);
  std::string stream;
  const auto taken = reader.take(served(0x02, "ok\n") + masked + served(0x82, "ok\n"), stream);
  ASSERT_FALSE(taken);
  EXPECT_NE(taken.error().message.find("masked"), std::string::npos) << taken.error().message;
  EXPECT_EQ(stream, "ok\n") << "zeros for a mask do not make it right";
  EXPECT_FALSE(reader.take(served(0x82, "ok\n"), stream));
  EXPECT_EQ(stream, "ok\n");
}

TEST(WebSocket, BrokenRulesAreToldAndNothingFollows) {
  const std::pair<std::string, const char*> cases[] = {
      {bytes({0x82, 0x85, 1, 2, 3, 4, 'a', 'b', 'c', 'd', 'e'}), "masked"},
      {served(0xC2, "x"), "reserved"},
      {served(0x92, "x"), "reserved"},
      {served(0x83, "x"), "unknown"},
      {served(0x8B, "x"), "unknown"},
      {served(0x09, "x"), "control"},
      {served(0x89, std::string(126, 'x')), "control"},
      {served(0x80, "x"), "piece of no message"},
      {served(0x02, "a") + served(0x82, "b"), "inside another"},
      {bytes({0x82, 127, 0x80, 0, 0, 0, 0, 0, 0, 1}), "length"},
  };
  for (const auto& [wire, what] : cases) {
    WebSocketReader reader(false);
    std::string stream;
    const auto taken = reader.take(wire, stream);
    ASSERT_FALSE(taken) << what;
    EXPECT_NE(taken.error().message.find(what), std::string::npos) << taken.error().message;
    EXPECT_FALSE(reader.take(served(0x82, "later"), stream));
    EXPECT_EQ(stream.find("later"), std::string::npos);
  }
}

TEST(WebSocket, OnlyTheAnswerToThisOpeningIsTaken) {
  const std::string key = "dGhlIHNhbXBsZSBub25jZQ==";
  const std::string good =
      "HTTP/1.1 101 Switching Protocols\r\nUPGRADE: WebSocket\r\nConnection: keep-alive, Upgrade\r\n"
      "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n";
  const auto plain = read_websocket_answer(good, key),
             agreed = read_websocket_answer(good + "Sec-WebSocket-Protocol: arduino\r\n", key);
  ASSERT_TRUE(plain);
  EXPECT_FALSE(*plain);
  ASSERT_TRUE(agreed);
  EXPECT_TRUE(*agreed);
  const auto without = [&](const std::string& part, const std::string& instead) {
    std::string text = good;
    text.replace(text.find(part), part.size(), instead);
    return text;
  };
  for (const std::string& bad :
       {std::string("HTTP/1.1 404 Not Found\r\n"), std::string("Grbl 1.1h\r\n"), std::string(),
        without("s3pP", "S3pP"), without("WebSocket", "h2c"), without("Upgrade\r\nSec", "close\r\nSec"),
        good + "Sec-WebSocket-Protocol: chat\r\n", good + "Sec-WebSocket-Extensions: permessage-deflate\r\n"})
    EXPECT_FALSE(read_websocket_answer(bad, key)) << bad;
  EXPECT_NE(read_websocket_answer("HTTP/1.1 404 Not Found\r\n", key).error().message.find("404 Not Found"),
            std::string::npos);
  const std::string request = websocket_request("mill:80", "/ws", key);
  EXPECT_EQ(request.rfind("GET /ws HTTP/1.1\r\nHost: mill:80\r\n", 0), 0u);
  EXPECT_TRUE(request.ends_with("\r\n\r\n"));
}

}  // namespace
}  // namespace tiltfeed
