// ModbusSession against a scripted ring controller: lost, repeated, damaged, torn and foreign messages.

#include "daemon/protocol/modbus_session.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/peers/fake_ring.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

TEST(ModbusSession, EveryBlockOnceInOrderWithOneRequestForSevenBlocks) {
  RingBench bench(1000);
  bench.per_turn = 7;
  while (bench.turn()) {
  }
  bench.check_all_executed_once();
  EXPECT_LE(bench.ring.windows, 1000 / 7 + 1);
  EXPECT_EQ(bench.session.state().resends, 0u);
}

TEST(ModbusSession, SaysWhenTheRingHasRunOut) {
  for (const int per_turn : {1, 100}) {
    RingBench bench(1000);
    bench.open();
    bench.per_turn = per_turn;
    int starved = 0, turns = 0;
    while (bench.turn() && bench.session.state().acknowledged < 900) {
      const auto said = bench.session.state().starved;
      ++turns;
      ASSERT_TRUE(said);
      starved += *said ? 1 : 0;
    }
    EXPECT_GT(turns, 100);
    if (per_turn == 1) {
      EXPECT_EQ(starved, 0);
    }
    if (per_turn == 100) {
      EXPECT_GT(2 * starved, turns);
    }
  }
}

TEST(ModbusSession, BlockWordsAreThoseOfTheMap) {
  RingBench bench(1);
  while (bench.turn()) {
  }
  const Words& block = bench.ring.last_block;
  const auto signed_pair = [&](std::size_t at) { return static_cast<std::int32_t>(pair(block, at)); };
  EXPECT_EQ(block[0], 1);
  EXPECT_EQ(block[1], 0x0102);
  EXPECT_EQ(pair(block, 2), 1u);
  EXPECT_EQ(signed_pair(4), 15000);
  EXPECT_EQ(signed_pair(6), 0);
  EXPECT_EQ(signed_pair(8), -1);
  EXPECT_EQ(signed_pair(10), -302500);
  EXPECT_EQ(signed_pair(12), 7201234);
  EXPECT_EQ(pair(block, 14), 12500u);

  NumericBlock m = block_at(9);
  m.op = BlockOp::kMCode;
  m.inverse_time = false;
  m.m_code = 3;
  m.spindle = 12000;
  const auto words = encode_block(m, 0xFFFF, RingIdentity{}, false);
  EXPECT_EQ((*words)[0], 0xFFFF);
  EXPECT_EQ((*words)[1], 4);
  EXPECT_EQ((*words)[5], 3);
  EXPECT_EQ(static_cast<std::uint32_t>((*words)[14]) << 16 | (*words)[15], 12000000u);
  m.op = BlockOp::kDwell;
  m.seconds = 2.5;
  EXPECT_EQ((*encode_block(m, 1, RingIdentity{}, false))[15], 2500);
  m.rotary = 214748.5;  // beyond 32 bits at 1e-4
  EXPECT_EQ(encode_block(m, 1, RingIdentity{}, false).error().code, Code::kLimit);
}

/// What a controller with another map sees, as the ring of the standard map would: areas elsewhere, low words
/// first. The check sum is over the words as they came.
ModbusReply serve_elsewhere(FakeRing& ring, const RingMap& map, ModbusRequest request) {
  const std::pair<std::uint16_t, std::uint16_t> areas[] = {{map.identity, 0x0000},
                                                           {map.window, 0x0100},
                                                           {map.mailbox, 0x0180},
                                                           {map.status, 0x0200},
                                                           {map.heartbeat, 0x0240}};
  const auto standard = [&](std::uint16_t address) -> std::uint16_t {
    for (const auto& [there, here] : areas)
      if (there == address) return here;
    ADD_FAILURE() << "address " << address << " is none of the map";
    return 0xFFFF;
  };
  Words& words = request.words;
  if (!words.empty()) request.write_address = standard(request.write_address);
  if (request.read_count > 0) request.read_address = standard(request.read_address);
  const std::size_t crc = words.size() == 118 ? 4 : words.size() == 7 ? 5 : 0;
  if (crc > 0) {
    const std::uint32_t sum = crc_bit_by_bit(words, crc);
    EXPECT_EQ(words[crc], sum & 0xFFFF);
    EXPECT_EQ(words[crc + 1], sum >> 16);
    for (std::size_t block = 6; words.size() == 118 && block < 118; block += 16)
      for (std::size_t i = block + 2; i < block + 16; i += 2) std::swap(words[i], words[i + 1]);
    if (words.size() == 7) std::swap(words[3], words[4]);
    const std::uint32_t again = crc_bit_by_bit(words, crc);
    words[crc] = static_cast<std::uint16_t>(again >> 16);
    words[crc + 1] = static_cast<std::uint16_t>(again & 0xFFFF);
  }
  return ring.serve(request);
}

TEST(ModbusSession, AddressesWordOrderScaleAndWatchdogAreThoseOfTheProfile) {
  RingMap map;
  map.identity = 0x3000;
  map.window = 0x1000;
  map.mailbox = 0x2080;
  map.status = 0x0010;
  map.heartbeat = 0x0900;
  map.low_word_first = true;
  map.linear_exponent = 3;
  map.rotary_exponent = 2;
  map.watchdog = 0.4;
  RingBench bench(20000, map);
  bench.per_turn = 7;
  const auto wire = [&map](FakeRing& ring, const ModbusRequest& request) {
    return serve_elsewhere(ring, map, request);
  };
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(bench.turn(wire)) << bench.session.error().message;
  EXPECT_EQ(static_cast<std::int32_t>(pair(bench.ring.last_block, 4)), 1500);
  EXPECT_EQ(static_cast<std::int32_t>(pair(bench.ring.last_block, 10)), -3025);
  Time last = bench.now;
  for (int beats = bench.ring.heartbeats; bench.turn(wire);) {
    if (bench.session.phase() != Phase::kRun || bench.ring.heartbeats != beats) last = bench.now;
    beats = bench.ring.heartbeats;
    ASSERT_LE(bench.now - last, milliseconds(120)) << "0.1 s is a quarter of this watchdog's time";
  }
  bench.check_all_executed_once();
}

TEST(ModbusSession, SequenceNumbersWrapOverSeventyThousandBlocks) {
  RingBench bench(70000);
  bench.per_turn = 7;
  while (bench.turn()) {
  }
  bench.check_all_executed_once();
  EXPECT_EQ(bench.ring.accepted, static_cast<std::uint16_t>(70000));
}

TEST(ModbusSession, AFullRingTakesWhatFits) {
  RingBench bench(500);
  bench.ring.slots = 9;
  bench.per_turn = 1;
  while (bench.turn()) {
  }
  bench.check_all_executed_once();
  RingBench tiny(50);
  tiny.ring.slots = 1;
  tiny.per_turn = 1;
  while (tiny.turn()) {
  }
  tiny.check_all_executed_once();
}

TEST(ModbusSession, AfterALostReplyTheIdenticalFrameGoesOut) {
  RingBench bench(100);
  bench.open();
  bench.turn([](FakeRing& ring, const ModbusRequest& request) {
    ring.serve(request);  // it arrived; only the reply is lost
    return ModbusReply{};
  });
  const std::string lost = bench.last_request;
  EXPECT_EQ(bench.session.state().acknowledged, 0u) << "progress without having read it";
  bench.turn();
  EXPECT_EQ(bench.last_request, lost);
  EXPECT_EQ(bench.session.state().acknowledged, 7u);
  while (bench.turn()) {
  }
  bench.check_all_executed_once();
  EXPECT_EQ(bench.session.state().resends, 1u);
}

TEST(ModbusSession, AnyMixOfLostRequestsAndRepliesExecutesEveryBlockOnce) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    RingBench bench(300);
    bench.ring.slots = 1 + static_cast<int>(random() % 40);
    bench.ring.fc23 = seed % 3 != 0;
    bench.per_turn = static_cast<int>(random() % 9);
    if (bench.per_turn == 0) bench.per_turn = 1;
    const auto wire = [&](FakeRing& ring, const ModbusRequest& request) -> ModbusReply {
      const auto luck = random() % 100;
      if (luck < 10) return {};  // the request is lost
      ModbusRequest arrived = request;
      if (luck < 15 && request.write_address == 0x0100 && !request.words.empty())
        arrived.words[10 + random() % 100] ^= 0x0400;  // damaged in the controller's registers
      ModbusReply reply = ring.serve(arrived);
      if (luck > 90) return {};                                         // the reply is lost
      if (luck > 85 && reply.words.size() == 24) reply.words[23] ^= 1;  // torn
      if (luck == 85) return {6, {}};                                   // busy
      return reply;
    };
    for (int i = 0; i < 100000 && bench.turn(wire); ++i) {
    }
    ASSERT_NO_FATAL_FAILURE(bench.check_all_executed_once()) << "seed " << seed;
  }
}

TEST(ModbusSession, FallsBackToSeparateWriteAndReadOnExceptionOne) {
  RingBench bench(100);
  bool refused = false;
  while (bench.turn([&](FakeRing& ring, const ModbusRequest& request) -> ModbusReply {
    if (!request.words.empty() && request.read_count > 0) {
      EXPECT_FALSE(refused) << "asked again after exception 1";
      refused = true;
      return {1, {}};  // although the identity says that it can
    }
    return ring.serve(request);
  })) {
  }
  EXPECT_TRUE(refused);
  bench.check_all_executed_once();
}

TEST(ModbusSession, ARestartedControllerIsAFaultAndGetsNothingMore) {
  RingBench bench(100);
  bench.open();
  bench.turn();
  bench.ring.boot = 78;
  bench.ring.state = 5;
  bench.ring.session = 0;
  bench.turn();
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_NE(bench.session.error().message.find("restarted"), std::string::npos);
  EXPECT_NE(bench.session.error().message.find("may have run"), std::string::npos);
  EXPECT_TRUE(bench.session.output(bench.now + seconds(1)).empty());
}

TEST(ModbusSession, TornOldAndForeignStatusesAreReadAgain) {
  for (int kind = 0; kind < 3; ++kind) {
    RingBench bench(100);
    bench.open();
    bench.turn();
    const std::uint64_t before = bench.session.state().acknowledged;
    const std::uint16_t seq = bench.ring.status_seq;
    const auto spoil = [&](FakeRing& ring, const ModbusRequest& request) {
      ModbusReply reply = ring.serve(request);
      if (kind == 0) reply.words[23] ^= 0x8000;
      if (kind == 1) reply.words[0] = reply.words[23] = seq;
      if (kind == 2) reply.words[2] = 0x1111;
      return reply;
    };
    bench.turn(spoil);
    EXPECT_EQ(bench.session.state().acknowledged, before) << kind;
    bench.turn();
    EXPECT_TRUE(unpack_request(bench.last_request).words.empty()) << "not a plain read, kind " << kind;
    EXPECT_EQ(bench.session.state().acknowledged, before + 7) << kind;
    for (int i = 0; i < 100; ++i) bench.turn(spoil);
    EXPECT_EQ(bench.session.phase(), Phase::kFault) << "bounded, kind " << kind;
  }
}

TEST(ModbusSession, ClaimsThatCannotBeTrueAreFaults) {
  RingBench bench(100);
  bench.open();
  bench.turn();
  bench.ring.accepted += 50;
  bench.turn();
  bench.turn();
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
}

TEST(ModbusSession, C17OneBlockMoreThanWasSentOrAcceptedIsAFault) {
  for (const bool completed : {false, true}) {
    RingBench bench(100);
    bench.per_turn = 0;
    bench.open();
    bench.turn();
    const auto sent = static_cast<std::uint16_t>(bench.session.state().sent);
    ASSERT_GT(sent, 0);
    ASSERT_EQ(bench.ring.accepted, sent);
    if (completed) bench.ring.completed = sent, bench.ring.used = 0;
    const auto claims = [&](FakeRing& ring, const ModbusRequest& request) {
      ModbusReply reply = ring.serve({0, request.read_address, request.read_count, {}});  // the frame is lost
      if (request.read_address != 0x0200 || reply.words.size() < 6) return reply;
      reply.words[3] = reply.words[4] = static_cast<std::uint16_t>(bench.session.state().sent + !completed);
      if (completed) reply.words[5] = static_cast<std::uint16_t>(reply.words[4] + 1);
      return reply;
    };
    for (int i = 0; i < 3 && bench.turn(claims); ++i) {
    }
    EXPECT_EQ(bench.session.phase(), Phase::kFault) << (completed ? "completed" : "accepted");
    EXPECT_NE(bench.session.error().message.find("never sent"), std::string::npos)
        << bench.session.error().message;
  }
}

TEST(ModbusSession, NothingFollowsBlocksThatWereDropped) {
  // Its ring was emptied beside the host: what is taken then makes last_completed pass over what was dropped.
  RingBench bench(100);
  bench.open();
  bench.per_turn = 0;
  for (int i = 0; i < 4; ++i) bench.turn();
  ASSERT_GT(bench.ring.used, 0);
  bench.ring.used = 0;
  bench.ring.state = 0;
  const std::uint64_t executed = bench.session.state().executed;
  bench.turn();  // what was on its way
  bench.ring.state = 0;
  const int windows = bench.ring.windows;
  const Time dropped = bench.now;
  while (bench.turn()) bench.ring.state = 0;
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_NE(bench.session.error().message.find("dropped"), std::string::npos);
  EXPECT_EQ(bench.ring.windows, windows);
  EXPECT_EQ(bench.session.state().executed, executed);
  EXPECT_LT(bench.now - dropped, seconds(11));
}

TEST(ModbusSession, AlarmAndBadBlockNameTheLine) {
  RingBench bench(100);
  bench.open();
  bench.per_turn = 0;
  bench.turn();
  bench.turn();
  bench.ring.alarm = 3;
  bench.ring.state = 4;
  bench.turn();
  ASSERT_EQ(bench.session.phase(), Phase::kAlarm);
  EXPECT_NE(bench.session.error().message.find("alarm 3"), std::string::npos);
  EXPECT_NE(bench.session.error().message.find("'G1X1.5F12.5'"), std::string::npos);
  RingBench bad(100);
  bad.open();
  bad.turn([](FakeRing& ring, const ModbusRequest& request) {
    ring.nack = 4;
    ring.nack_seq = 3;
    return ModbusReply{kReplyOk, ring.read(request.read_address, request.read_count)};
  });
  ASSERT_EQ(bad.session.phase(), Phase::kFault);
  EXPECT_NE(bad.session.error().message.find("line 3"), std::string::npos) << bad.session.error().message;
}

TEST(ModbusSession, AFrameThatIsAlwaysRefusedEndsInAFault) {
  RingBench bench(100);
  bench.open();
  int frames = 0;
  while (bench.turn([&](FakeRing& ring, const ModbusRequest& request) {
    if (request.write_address == 0x0100) ++frames;
    ring.nack = 2;
    return ModbusReply{kReplyOk, ring.read(request.read_address, request.read_count)};
  })) {
  }
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_EQ(frames, 11);
}

TEST(ModbusSession, NoReplyForTenSecondsIsAFault) {
  RingBench bench(100);
  bench.open();
  const Time from = bench.now;
  while (bench.turn([&](FakeRing&, const ModbusRequest&) {
    bench.now += milliseconds(400);
    return ModbusReply{};
  })) {
  }
  EXPECT_GE(bench.now - from, seconds(10));
  EXPECT_LE(bench.now - from, seconds(11));
}

TEST(ModbusSession, HoldIsWaitedForAndTheHeartbeatGoesOn) {
  RingBench bench(200);
  bench.open();
  for (int i = 0; i < 5; ++i) bench.turn();
  bench.ring.state = 2;
  const Time from = bench.now;
  Time last = bench.now;
  int beats = bench.ring.heartbeats;
  while (bench.now - from < seconds(60)) {
    ASSERT_TRUE(bench.turn()) << bench.session.error().message;
    if (bench.ring.heartbeats != beats) last = bench.now;
    beats = bench.ring.heartbeats;
    ASSERT_LE(bench.now - last, milliseconds(300));
  }
  bench.ring.state = 1;
  while (bench.turn()) {
  }
  bench.check_all_executed_once();
}

TEST(ModbusSession, TheHeartbeatIsKeptUpWhileFramesFlow) {
  RingBench bench(20000);
  bench.per_turn = 7;
  int beats = 0;
  Time last{0};
  while (bench.turn()) {
    if (bench.session.phase() != Phase::kRun) last = bench.now;
    if (bench.ring.heartbeats != beats) last = bench.now;
    beats = bench.ring.heartbeats;
    ASSERT_LE(bench.now - last, milliseconds(300));
  }
  bench.check_all_executed_once();
}

TEST(ModbusSession, StopHoldsByTheMailbox) {
  RingBench bench(200);
  bench.open();
  for (int i = 0; i < 5; ++i) bench.turn();
  bench.session.command({Order::kStop}, bench.now);
  while (bench.turn()) {
  }
  EXPECT_EQ(bench.ring.commands[2], 1);
  EXPECT_EQ(bench.ring.commands[4], 1);
  EXPECT_EQ(bench.ring.commands[8], 1);
  EXPECT_EQ(bench.session.phase(), Phase::kStopped);
  EXPECT_EQ(bench.session.error().code, Code::kCancelled);
  EXPECT_NE(bench.session.error().message.find("stopped on request"), std::string::npos);
}

/// A controller that is late with its mailbox is no fault until 5 s are over, however quick its replies are.
TEST(ModbusSession, ACommandHasTimeToBeObeyed) {
  for (const auto& [late, obeyed] : {std::pair(milliseconds(4000), true), {milliseconds(60000), false}}) {
    RingBench bench(200);
    bench.open();
    for (int i = 0; i < 5; ++i) bench.turn();
    bench.session.command({Order::kStop}, bench.now);
    const Time from = bench.now;
    while (bench.turn([&, late = late](FakeRing& ring, const ModbusRequest& request) {
      ModbusRequest heard = request;
      if (request.write_address == RingMap{}.mailbox && bench.now - from < late) heard.words.clear();
      return ring.serve(heard);
    })) {
    }
    EXPECT_EQ(bench.session.phase(), obeyed ? Phase::kStopped : Phase::kFault)
        << bench.session.error().message;
    if (obeyed) continue;
    EXPECT_NE(bench.session.error().message.find("does not obey"), std::string::npos);
    EXPECT_GE(bench.now - from, seconds(5));
    EXPECT_LE(bench.now - from, seconds(6));
  }
}

TEST(ModbusSession, RefusesAnotherMapAndABusyMachine) {
  RingBench map(5);
  while (map.turn([](FakeRing&, const ModbusRequest&) { return ModbusReply{kReplyOk, Words(16, 7)}; })) {
  }
  EXPECT_NE(map.session.error().message.find("0x5446"), std::string::npos);
  RingBench wrong(5);
  while (wrong.turn([](FakeRing&, const ModbusRequest&) { return ModbusReply{2, {}}; })) {
  }
  EXPECT_EQ(wrong.session.phase(), Phase::kFault);
  RingBench busy(5);
  busy.ring.state = 1;
  busy.ring.session = 9;
  while (busy.turn()) {
  }
  EXPECT_EQ(busy.session.phase(), Phase::kFault);
  EXPECT_EQ(busy.ring.commands[1], 0);
}

}  // namespace
}  // namespace tiltfeed
