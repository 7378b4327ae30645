// The register-map model under a scripted clock: frames are built here, word by word, from the map in
// sim/controller/README.md.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/controller/modbus_controller.h"
#include "tests/judges/crc_bit_by_bit.h"
#include "tests/peers/sim_machine.h"

namespace tiltfeed::sim {
using namespace config;
namespace {

void put(Words& words, std::size_t at, std::uint32_t value) {
  words[at] = static_cast<std::uint16_t>(value >> 16);
  words[at + 1] = static_cast<std::uint16_t>(value);
}

/// A feed move of G93: to x mm in `seconds`.
Words feed(double x, double seconds = 1.0, std::uint32_t line = 0) {
  Words block(16);
  block[1] = 0x0102;
  put(block, 2, line);
  put(block, 4, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(x * 1e4))));
  put(block, 14, static_cast<std::uint32_t>(std::lround(60e3 / seconds)));
  return block;
}

Words window(std::uint16_t session, std::uint16_t first, const std::vector<Words>& blocks, bool end = false) {
  Words words(118);
  words[0] = session;
  words[1] = first;
  words[2] = static_cast<std::uint16_t>(blocks.size());
  words[3] = end ? 1 : 0;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    std::copy(blocks[k].begin(), blocks[k].end(), words.begin() + 6 + 16 * static_cast<int>(k));
    words[6 + 16 * k] = static_cast<std::uint16_t>(first + k);
  }
  put(words, 4, crc_bit_by_bit(words, 4));
  return words;
}

Words mailbox(std::uint16_t session, std::uint16_t seq, Command command, std::uint32_t argument = 0) {
  Words words{session, seq, static_cast<std::uint16_t>(command), 0, 0, 0, 0};
  put(words, 3, argument);
  put(words, 5, crc_bit_by_bit(words, 5));
  return words;
}

class Modbus : public ::testing::Test {
 protected:
  explicit Modbus(std::size_t ring = 8)
      : controller(test_machine(), {}, {.ring = ring, .boot_id = 77},
                   [this](const TraceRow& row) { rows.push_back(row); }) {
    EXPECT_EQ(command(Command::kOpen), 0);
  }
  Words status() {
    Words words(24);
    EXPECT_EQ(controller.read(0x0200, words), Access::kOk);
    EXPECT_EQ(words[0], words[23]);
    return words;
  }
  /// cmd_result
  int command(Command code, std::uint32_t argument = 0, std::uint16_t session = 5) {
    EXPECT_EQ(controller.write(0x0180, mailbox(session, ++cmd_seq_, code, argument)), Access::kOk);
    const Words s = status();
    EXPECT_EQ(s[11], cmd_seq_);
    return s[12];
  }
  void send(const Words& words) { EXPECT_EQ(controller.write(0x0100, words), Access::kOk); }
  /// first..first+n-1, each a second to x = its number
  Words frame(int first, int n) {
    std::vector<Words> blocks;
    for (int i = 0; i < n; ++i) blocks.push_back(feed(first + i));
    return window(5, static_cast<std::uint16_t>(first), blocks);
  }
  RunState state() { return static_cast<RunState>(status()[7]); }
  Nack nack() { return static_cast<Nack>(status()[9]); }

  std::vector<TraceRow> rows;
  ModbusController controller;
  std::uint16_t cmd_seq_ = 0;
};

TEST(ModbusMap, CrcIsTheIeeeOne) {
  const Words digits{0x3132, 0x3334, 0x3536, 0x3738};  // "12345678"
  EXPECT_EQ(crc_of_words(digits), 0x9AE0DAAFU);
  EXPECT_EQ(crc_bit_by_bit(digits, digits.size()), 0x9AE0DAAFU);
  const Words many(117, 0xA5C3);  // longer than the pieces it is computed in
  EXPECT_EQ(crc_of_words(many), crc_bit_by_bit(many, many.size()));
}

TEST_F(Modbus, IdentityAndAddresses) {
  Words identity(16);
  ASSERT_EQ(controller.read(0x0000, identity), Access::kOk);
  EXPECT_EQ(identity, (Words{0x5446, 1, 15, 8, 16, 7, 31, 4, 4, 77, 0, 0, 0, 0, 0, 0}));
  const auto read = [&](std::uint16_t at, std::size_t n) {
    Words words(n);
    return controller.read(at, words);
  };
  EXPECT_EQ(read(0x0201, 3), Access::kOk);
  EXPECT_EQ(read(0x0220, 10), Access::kOk);
  for (const auto& [at, n] : std::vector<std::pair<std::uint16_t, std::size_t>>{{0x0000, 17},
                                                                                {0x0010, 1},
                                                                                {0x0100, 1},
                                                                                {0x0180, 7},
                                                                                {0x0200, 25},
                                                                                {0x0218, 1},
                                                                                {0x0220, 11},
                                                                                {0x0240, 1},
                                                                                {0xFFFF, 2}})
    EXPECT_EQ(read(at, n), Access::kIllegalAddress) << at << " " << n;
  EXPECT_EQ(read(0x0000, 126), Access::kIllegalValue);
  EXPECT_EQ(controller.write(0x0000, Words(1)), Access::kIllegalAddress);
  EXPECT_EQ(controller.write(0x0101, Words(117)), Access::kIllegalAddress);
  EXPECT_EQ(controller.write(0x0200, Words(1)), Access::kIllegalAddress);
  EXPECT_EQ(controller.write(0x0100, Words(117)), Access::kIllegalValue);
  EXPECT_EQ(controller.write(0x0180, Words(6)), Access::kIllegalValue);
  EXPECT_EQ(controller.write(0x0240, Words(2)), Access::kIllegalValue);
}

/// Axes of a rapid that stay where they are, and the place of Z in machine coordinates.
TEST_F(Modbus, KeptAxesStayAndMachineCoordinatesCountFromTheTop) {
  Words retract(16), turn(16), place(16);
  retract[1] = 1 | 1 << 14 | 0b11011 << 9;
  put(retract, 8, static_cast<std::uint32_t>(-10000));  // Z 1 mm below the top
  turn[1] = 1 | 0b00111 << 9;
  put(turn, 10, 50000), put(turn, 12, 70000);  // A 5 C 7
  put(turn, 4, 990000);                        // an X that means nothing
  place[1] = 1 | 0b11100 << 9;
  put(place, 4, 20000), put(place, 6, 30000);  // X 2 Y 3
  command(Command::kOpen);
  send(window(5, 1, {retract, turn, place}));
  controller.advance(100.0);
  ASSERT_EQ(rows.size(), 3U);
  const double top = rows[0].command.target.z;
  EXPECT_GT(top, 1.0);
  EXPECT_EQ(rows[0].command.target, (Joints{0, 0, top, 0, 0}));
  EXPECT_EQ(rows[1].command.target, (Joints{0, 0, top, 5, 7}));
  EXPECT_EQ(rows[2].command.target, (Joints{2, 3, top, 5, 7}));
  Words feeds = retract;
  feeds[1] = 2 | 1 << 14;
  put(feeds, 14, 1000);
  send(window(5, 4, {feeds}));
  EXPECT_EQ(nack(), Nack::kBadBlock) << "machine coordinates are for rapids";
}

TEST_F(Modbus, ExecutesBlocksOfEveryKind) {
  Words rapid(16), dwell(16), spindle(16);
  rapid[1] = 1;
  put(rapid, 4, 100000);                                // X 10
  put(rapid, 10, static_cast<std::uint32_t>(-123456));  // A -12.3456
  put(rapid, 12, 1800001);                              // C 180.0001
  dwell[1] = 3;
  put(dwell, 14, 250);
  spindle[1] = 4;
  put(spindle, 4, 3);
  put(spindle, 14, 8000000);
  Words per_minute = feed(20, 1, 4000000000);
  per_minute[1] = 2;
  put(per_minute, 14, 600000);  // 600 mm/min
  send(window(5, 1, {spindle, rapid, dwell, per_minute}, true));
  EXPECT_EQ(state(), RunState::kRunning);
  controller.advance(100);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].command.m_code, 3);
  EXPECT_EQ(rows[0].command.spindle, 8000);
  EXPECT_EQ(rows[1].command.target, (Joints{10, 0, 0, -12.3456, 180.0001}));
  EXPECT_DOUBLE_EQ(rows[2].end - rows[2].start, 0.25);
  EXPECT_EQ(rows[2].command.target, rows[1].command.target);
  EXPECT_EQ(rows[3].command.line, 4000000000U);
  EXPECT_EQ(rows[3].command.feed, 600);
  EXPECT_DOUBLE_EQ(rows[3].end - rows[3].start, 1.0) << "10 mm at 600 mm/min";
  EXPECT_EQ(state(), RunState::kDone);
  EXPECT_TRUE(controller.program_ended());
  Words positions(10);
  ASSERT_EQ(controller.read(0x0220, positions), Access::kOk);
  EXPECT_EQ(positions, (Words{3, 0x0D40, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST_F(Modbus, ShowsWhatIsAcceptedStartedAndCompleted) {
  send(frame(1, 5));
  controller.advance(2.5);
  const Words s = status();
  EXPECT_EQ(s[1], 77);
  EXPECT_EQ(s[2], 5);
  EXPECT_EQ((Words{s[3], s[4], s[5], s[6]}), (Words{5, 3, 2, 5}));
  EXPECT_EQ(static_cast<std::uint16_t>(s[0] + 1), status()[0]) << "status_seq counts reads";
}

TEST_F(Modbus, RepeatedFramesAreExecutedOnce) {
  for (int i = 0; i < 5; ++i) send(frame(1, 3));
  EXPECT_EQ(nack(), Nack::kNone);
  controller.advance(1.5);
  for (int i = 0; i < 5; ++i) send(frame(1, 3));
  send(frame(2, 4));  // 2 and 3 are known, 4 and 5 new
  send(frame(1, 3));
  controller.advance(100);
  send(frame(1, 5));
  controller.advance(200);
  ASSERT_EQ(rows.size(), 5U);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(rows[static_cast<std::size_t>(i)].command.target.x, i + 1);
}

TEST_F(Modbus, DamagedFramesChangeNothing) {
  const Words good = frame(1, 3);
  for (std::size_t word = 0; word < good.size(); ++word) {
    Words bad = good;
    bad[word] ^= static_cast<std::uint16_t>(1U << (word % 16));
    send(bad);
    EXPECT_EQ(nack(), Nack::kCrc) << word;
    EXPECT_EQ(status()[3], 0) << word;
  }
  send(good);
  EXPECT_EQ(nack(), Nack::kNone);
  EXPECT_EQ(status()[3], 3);
}

TEST_F(Modbus, GapSessionAndBadBlocksAreRefusedWhole) {
  send(frame(1, 2));
  send(frame(4, 2));
  EXPECT_EQ(nack(), Nack::kGap);
  EXPECT_EQ(status()[10], 4);
  send(window(6, 3, {feed(1)}));
  EXPECT_EQ(nack(), Nack::kSession);
  Words tcp = feed(1), no_feed = feed(1), op9 = feed(1), fast_rapid = feed(1), flagged_rapid = feed(1);
  tcp[1] = 0x0302;
  put(no_feed, 14, 0);
  op9[1] = 9;
  fast_rapid[1] = 1;
  flagged_rapid[1] = 0x0101;
  put(flagged_rapid, 14, 0);
  for (const Words& bad : {tcp, no_feed, op9, fast_rapid, flagged_rapid}) {
    send(window(5, 3, {feed(3), bad}));
    EXPECT_EQ(nack(), Nack::kBadBlock);
    EXPECT_EQ(status()[10], 4);
  }
  send(window(5, 3, {}));
  EXPECT_EQ(nack(), Nack::kBadBlock);
  EXPECT_EQ(status()[3], 2);
  send(frame(3, 1));
  EXPECT_EQ(nack(), Nack::kNone);
  EXPECT_EQ(status()[3], 3);
}

TEST_F(Modbus, AFullRingTakesWhatFits) {
  send(frame(1, 7));
  send(frame(8, 7));
  EXPECT_EQ(status()[3], 8);
  EXPECT_EQ(status()[6], 0);
  EXPECT_EQ(nack(), Nack::kNone);
  controller.advance(3);
  send(frame(8, 7));
  EXPECT_EQ(status()[3], 11);
  controller.advance(100);
  send(frame(8, 7));
  controller.advance(200);
  ASSERT_EQ(rows.size(), 14U);
  for (std::size_t i = 0; i < 14; ++i) EXPECT_EQ(rows[i].command.target.x, static_cast<double>(i + 1));
}

TEST_F(Modbus, SequenceNumbersWrapOverSeventyThousandBlocks) {
  constexpr int kBlocks = 70000;
  for (int next = 1; next <= kBlocks;) {
    std::vector<Words> blocks;
    for (int i = 0; i < 7 && next + i <= kBlocks; ++i) blocks.push_back(feed((next + i) % 400, 0.5));
    const Words words = window(5, static_cast<std::uint16_t>(next), blocks, next + 7 > kBlocks);
    send(words);
    send(words);
    const auto moved = static_cast<std::int16_t>(static_cast<std::uint16_t>(status()[3] - (next - 1)));
    ASSERT_GE(moved, 0);
    next += moved;
    controller.advance(controller.now() + 1.5);
  }
  controller.advance(1e6);
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(kBlocks));
  for (int i = 0; i < kBlocks; ++i)
    ASSERT_EQ(rows[static_cast<std::size_t>(i)].command.target.x, (i + 1) % 400) << i;
  EXPECT_EQ(status()[5], static_cast<std::uint16_t>(kBlocks));
  EXPECT_EQ(state(), RunState::kDone);
}

TEST_F(Modbus, OnlyTheLastBlockEndsAProgram) {
  const Words ending = window(5, 1, {feed(1), feed(2)}, true);
  send(ending);
  EXPECT_EQ(state(), RunState::kRunning);
  controller.advance(10);
  EXPECT_EQ(state(), RunState::kDone);
  send(frame(3, 2));
  send(ending);  // late: its end is no longer the end
  controller.advance(20);
  EXPECT_EQ(state(), RunState::kIdle);
  send(window(5, 4, {feed(4)}, true));  // the end may be told after the block was executed
  EXPECT_EQ(state(), RunState::kDone);
}

TEST_F(Modbus, CommandsActOnce) {
  send(frame(1, 3));
  controller.advance(0.5);
  EXPECT_EQ(command(Command::kHold), 0);
  EXPECT_EQ(state(), RunState::kHold);
  controller.advance(50);
  EXPECT_EQ(status()[5], 0);
  EXPECT_EQ(command(Command::kResume), 0);
  const Words hold_again = mailbox(5, cmd_seq_, Command::kHold);  // the number of the resume: known
  EXPECT_EQ(controller.write(0x0180, hold_again), Access::kOk);
  EXPECT_EQ(state(), RunState::kRunning);
  Words damaged = mailbox(5, 99, Command::kHold);
  damaged[4] ^= 1;
  EXPECT_EQ(controller.write(0x0180, damaged), Access::kOk);
  EXPECT_EQ(status()[11], cmd_seq_) << "not acknowledged";
  EXPECT_EQ(command(Command::kOverride, 50), 0);
  EXPECT_EQ(status()[13], 50);
  EXPECT_EQ(command(Command::kOverride, 5), 1);
  EXPECT_EQ(command(Command::kHold, 0, 6), 1) << "another session";
  EXPECT_EQ(command(static_cast<Command>(9)), 1);
  EXPECT_EQ(command(Command::kClose), 1) << "not while blocks are queued";
  controller.advance(100);
  EXPECT_EQ(command(Command::kClose), 0);
  EXPECT_EQ(state(), RunState::kNoSession);
  send(frame(4, 1));
  EXPECT_EQ(nack(), Nack::kSession);
}

TEST_F(Modbus, OpeningAgainKeepsTheNumbersANewSessionStartsThem) {
  send(frame(1, 3));
  EXPECT_EQ(command(Command::kOpen), 0);
  EXPECT_EQ(status()[3], 3);
  EXPECT_EQ(command(Command::kOpen, 0, 6), 1) << "not while the old session's blocks run";
  controller.advance(50);
  EXPECT_EQ(command(Command::kOpen, 0, 0), 1);
  EXPECT_EQ(command(Command::kOpen, 0, 6), 0);
  const Words s = status();
  EXPECT_EQ((Words{s[2], s[3], s[4], s[5]}), (Words{6, 0, 0, 0}));
  send(window(6, 1, {feed(9)}));
  EXPECT_EQ(status()[3], 1);
}

TEST_F(Modbus, StopForgetsButKeepsTheNumbers) {
  send(frame(1, 5));
  controller.advance(1.5);
  EXPECT_EQ(command(Command::kStop), 0);
  const Words s = status();
  EXPECT_EQ((Words{s[3], s[4], s[5], s[6]}), (Words{5, 2, 1, 8}));
  EXPECT_EQ(state(), RunState::kIdle);
  controller.advance(50);
  EXPECT_EQ(rows.size(), 1U);
}

TEST_F(Modbus, ResetIsARestart) {
  send(frame(1, 5));
  controller.advance(1.5);
  EXPECT_EQ(command(Command::kReset), 0);
  Words s = status();
  EXPECT_EQ((Words{s[1], s[2], s[3], s[5], s[7], s[8]}), (Words{78, 0, 0, 0, 4, 3}));
  EXPECT_EQ(command(Command::kClearAlarm, 0, 0), 0);
  EXPECT_EQ(state(), RunState::kNoSession);
}

TEST_F(Modbus, SoftLimitIsAnAlarm) {
  send(window(5, 1, {feed(1), feed(500.0001), feed(2)}));
  const Words s = status();
  EXPECT_EQ((Words{s[3], s[7], s[8]}), (Words{1, 4, 2}));
  send(frame(2, 1));
  EXPECT_EQ(status()[3], 1) << "nothing is taken in an alarm";
  EXPECT_EQ(command(Command::kClearAlarm), 0);
  send(frame(2, 1));
  EXPECT_EQ(status()[9], 3) << "what follows dropped blocks would make them look completed";
  controller.advance(50);
  EXPECT_EQ(rows.size(), 0U);
}

TEST_F(Modbus, M0HoldsUntilResume) {
  Words wait(16);
  wait[1] = 4;
  send(window(5, 1, {feed(1), wait, feed(2)}));
  controller.advance(50);
  EXPECT_EQ(state(), RunState::kHold);
  EXPECT_EQ(status()[4], 2);
  EXPECT_EQ(command(Command::kResume), 0);
  EXPECT_EQ(status()[4], 3);
  controller.advance(60);
  EXPECT_EQ(rows.size(), 3U);
}

TEST_F(Modbus, WatchdogHoldsWhenTheHeartbeatStops) {
  send(frame(1, 7));
  controller.advance(1.5);
  controller.advance_link(1.5);
  EXPECT_EQ(state(), RunState::kRunning) << "no heartbeat was ever written: not armed";
  const auto beat = [&](std::uint16_t value) {
    EXPECT_EQ(controller.write(0x0240, Words{value}), Access::kOk);
    EXPECT_EQ(status()[14], value);
  };
  beat(1);
  controller.advance_link(2.4);
  beat(2);
  controller.advance_link(3.3);
  EXPECT_EQ(state(), RunState::kRunning);
  beat(2);  // written, but not changed
  controller.advance_link(3.5);
  EXPECT_EQ(state(), RunState::kHold);
  EXPECT_EQ(command(Command::kResume), 1) << "not while the host is silent";
  beat(3);
  EXPECT_EQ(state(), RunState::kHold) << "nothing resumes by itself";
  EXPECT_EQ(command(Command::kResume), 0);
  controller.advance(100);
  EXPECT_EQ(rows.size(), 7U);
}

}  // namespace
}  // namespace tiltfeed::sim
