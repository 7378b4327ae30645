#pragma once
// A scripted ring controller in made-up time, written from the map again with a bitwise CRC; it shares only
// the packing of a request with the session.

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/protocol/modbus_session.h"
#include "tests/judges/crc_bit_by_bit.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

using std::chrono::milliseconds;
using std::chrono::seconds;

inline std::uint32_t pair(const Words& words, std::size_t at) {
  return static_cast<std::uint32_t>(words[at]) << 16 | words[at + 1];
}

struct FakeRing {
  bool fc23 = true;
  std::uint16_t boot = 77, session = 0, status_seq = 0, accepted = 0, completed = 0, ack = 5, state = 5;
  std::uint16_t nack = 0, nack_seq = 0, alarm = 0;
  int slots = 32, used = 0, windows = 0, heartbeats = 0, bad_crc = 0;
  bool end_seen = false;
  bool keeps_session = false;        // refuses to stop and to close
  std::uint16_t result = 0;          // of the newest command
  std::optional<Words> positions;    // as they are read; nothing: it reports none
  std::vector<std::uint32_t> lines;  // of accepted blocks, in order
  Words last_block;
  std::map<int, int> commands;  // code -> times executed

  void write(std::uint16_t address, const Words& words) {
    if (address == 0x0240) ++heartbeats;
    if (address == 0x0180) mailbox(words);
    if (address == 0x0100) window(words);
  }
  void mailbox(const Words& words) {
    ASSERT_EQ(words.size(), 7u);
    ASSERT_EQ(pair(words, 5), crc_bit_by_bit(words, 5));
    if (words[1] == ack) return;
    ack = words[1];
    ++commands[words[2]];
    result = keeps_session && (words[2] == 4 || words[2] == 8) ? 1 : 0;
    if (result != 0) return;
    if (words[2] == 1) {
      session = words[0];
      accepted = completed = 0;
      used = 0;
      state = 0;
    } else if (words[2] == 8) {
      session = 0;
      state = 5;
    } else if (words[2] == 2) {
      state = 2;
    }
  }
  void window(const Words& words) {
    ++windows;
    ASSERT_EQ(words.size(), 118u);
    nack = 0;
    if (pair(words, 4) != crc_bit_by_bit(words, 4)) {
      ++bad_crc;
      nack = 2;
      return;
    }
    if (words[0] != session) {
      nack = 3;
      return;
    }
    ASSERT_EQ(words[1], words[6]);
    for (int k = 0; k < words[2]; ++k) {
      const Words block(words.begin() + 6 + 16 * k, words.begin() + 22 + 16 * k);
      const int distance = static_cast<std::int16_t>(static_cast<std::uint16_t>(block[0] - accepted));
      if (distance <= 0) continue;
      if (distance > 1) {
        nack = 1;
        nack_seq = block[0];
        return;
      }
      if (used == slots) return;
      ++used;
      accepted = block[0];
      lines.push_back(pair(block, 2));
      last_block = block;
      if ((words[3] & 1) != 0 && k == words[2] - 1) end_seen = true;
    }
    if (words[2] < 7) {
      ASSERT_EQ(words[117], 0) << "unused blocks must be zero";
    }
    if (state == 0) state = 1;
  }
  void execute(int blocks) {
    for (; blocks > 0 && used > 0 && state == 1; --blocks) {
      --used;
      ++completed;
    }
    if (used == 0 && end_seen && state == 1) state = 3;
  }
  Words read(std::uint16_t address, std::uint16_t count) {
    Words words(count, 0);
    if (address == 0)
      words = {0x5446,
               1,
               static_cast<std::uint16_t>((fc23 ? 3 : 2) | (positions ? 4 : 0)),
               static_cast<std::uint16_t>(slots),
               16,
               7,
               31,
               4,
               4,
               boot,
               0,
               0,
               0,
               0,
               0,
               0};
    if (address == 0x0200) {
      ++status_seq;
      words = {status_seq,
               boot,
               session,
               accepted,
               accepted,
               completed,
               static_cast<std::uint16_t>(slots - used),
               state,
               alarm,
               nack,
               nack_seq,
               ack,
               result,
               100,
               0,
               0,
               0,
               0,
               0,
               0,
               0,
               0,
               0,
               status_seq};
    }
    if (address == 0x0220 && positions) words = *positions;
    return words;
  }
  /// Write first, then read, as FC23 does.
  ModbusReply serve(const ModbusRequest& request) {
    if (!fc23 && !request.words.empty() && request.read_count > 0) return {1, {}};
    if (!request.words.empty()) write(request.write_address, request.words);
    ModbusReply reply{kReplyOk, {}};
    if (request.read_count > 0) reply.words = read(request.read_address, request.read_count);
    return reply;
  }
};

inline NumericBlock block_at(std::uint64_t line) {
  NumericBlock block;
  block.op = BlockOp::kFeed;
  block.inverse_time = true;
  block.line = line;
  block.x = 1.5;
  block.z = -0.0001;
  block.tilt = -30.25;
  block.rotary = 720.1234;
  block.feed = 12.5;
  block.text = "G1X1.5F12.5";
  return block;
}

struct RingBench {
  explicit RingBench(std::uint64_t blocks, const RingMap& map = {})
      : count(blocks), session({blocks, 0x4321, map}, Time{0}) {}

  void feed() {
    while (session.wants_work()) {
      if (next > count) return session.end_of_program();
      session.push(block(next++));
    }
  }
  /// One turn; `wire` may change the reply, or lose request or reply.
  using Wire = std::function<ModbusReply(FakeRing&, const ModbusRequest&)>;
  bool turn(const Wire& wire = [](FakeRing& served, const ModbusRequest& request) {
    return served.serve(request);
  }) {
    feed();
    const std::string request(session.output(now));
    if (request.empty()) {
      now = std::max(now + milliseconds(1), session.deadline());
      return !is_final(session.phase());
    }
    session.sent(request.size());
    last_request = request;
    const ModbusReply reply = wire(ring, unpack_request(request));
    now += milliseconds(1);
    session.receive(pack_reply(reply), now);
    ring.execute(per_turn);
    return !is_final(session.phase());
  }
  void open() {
    for (int i = 0; i < 20 && is_opening(session.phase()); ++i) turn();
    ASSERT_EQ(session.phase(), Phase::kRun) << session.error().message;
  }
  void check_all_executed_once() {
    ASSERT_EQ(session.phase(), Phase::kDone) << session.error().message;
    ASSERT_EQ(ring.lines.size(), count);
    for (std::uint64_t i = 0; i < count; ++i) ASSERT_EQ(ring.lines[i], i + 1);
    EXPECT_EQ(session.state().executed, count);
    EXPECT_EQ(session.state().acknowledged, count);
    EXPECT_TRUE(ring.end_seen);
    EXPECT_EQ(ring.commands[1], 1);
    EXPECT_EQ(ring.commands[8], 1);
  }

  std::uint64_t count, next = 1;
  std::function<NumericBlock(std::uint64_t)> block = block_at;
  FakeRing ring;
  Time now{0};
  ModbusSession session;
  std::string last_request;
  int per_turn = 5;
};

}  // namespace tiltfeed
