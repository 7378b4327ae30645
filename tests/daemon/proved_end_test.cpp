// What a session says of its end: that a block was executed only where that is proved.

#include <gtest/gtest.h>

#include "daemon/journal/run_recorder.h"
#include "daemon/protocol/drip_session.h"
#include "daemon/protocol/drive_session.h"
#include "daemon/protocol/modbus_session.h"
#include "tests/peers/fake_ring.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr std::uint64_t kBlocks = 20;

bool has(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

/// Where block_at() leads, in ten thousandths.
Words program_end() {
  Words words;
  for (const std::int32_t value : {15000, 0, -1, -302500, 7201234}) {
    words.push_back(static_cast<std::uint16_t>(static_cast<std::uint32_t>(value) >> 16));
    words.push_back(static_cast<std::uint16_t>(value));
  }
  return words;
}

bool asks_place(const ModbusRequest& request) { return request.read_address == 0x0220; }

/// Until the session asks where the axes are.
void run_to_place(RingBench& bench) {
  bool asked = false;
  const RingBench::Wire wire = [&](FakeRing& ring, const ModbusRequest& request) {
    asked = asked || asks_place(request);
    return asked ? ModbusReply{} : ring.serve(request);
  };
  while (!asked && bench.turn(wire)) continue;
  ASSERT_TRUE(asked);
  ASSERT_EQ(bench.ring.completed, kBlocks);
}

void expect_last_in_doubt(const ModbusSession& session) {
  EXPECT_EQ(session.phase(), Phase::kFault);
  EXPECT_EQ(session.state().executed, kBlocks - 1);
  EXPECT_EQ(session.state().uncertain.first, kBlocks);
  EXPECT_EQ(session.state().uncertain.last, kBlocks);
  const std::string& why = session.error().message;
  EXPECT_TRUE(has(why, "every block is counted as executed, but the axes were not read")) << why;
  EXPECT_TRUE(has(why, "block 20 may have run")) << why;
}

TEST(ProvedEnd, ARingWhoseWireGoesBeforeThePlaceIsReadIsNotDone) {
  RingBench bench(kBlocks);
  bench.ring.positions = program_end();
  run_to_place(bench);
  bench.session.link_lost({Code::kLink, "the wire has gone"});
  expect_last_in_doubt(bench.session);
  EXPECT_EQ(bench.session.state().loss, Loss::kWire);
}

TEST(ProvedEnd, ARingThatFallsSilentBeforeThePlaceIsReadIsNotDone) {
  RingBench bench(kBlocks);
  bench.ring.positions = program_end();
  run_to_place(bench);
  while (bench.turn([](FakeRing&, const ModbusRequest&) { return ModbusReply{}; }))
    bench.now += milliseconds(300);
  expect_last_in_doubt(bench.session);
}

TEST(ProvedEnd, AReadingOfAnotherLengthIsNoPlace) {
  RingBench bench(kBlocks);
  bench.ring.positions = Words(4, 0);
  while (bench.turn()) continue;
  expect_last_in_doubt(bench.session);
}

TEST(ProvedEnd, ARingWhoseAxesAreElsewhereSaysNoWordOfAllBlocks) {
  RingBench bench(kBlocks);
  bench.ring.positions = Words(10, 0);
  while (bench.turn()) continue;
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_EQ(bench.session.state().executed, kBlocks - 1);
  const std::string& why = bench.session.error().message;
  EXPECT_TRUE(has(why, "not at the program's end")) << why;
  EXPECT_FALSE(has(why, "that were sent have run")) << why;
}

TEST(ProvedEnd, ARingIsDoneWhenItsPlaceWasReadWhateverBecomesOfItsSession) {
  RingBench bench(kBlocks);
  bench.ring.positions = program_end();
  bool placed = false;
  while (bench.turn([&](FakeRing& ring, const ModbusRequest& request) {
    if (placed) return ModbusReply{};
    placed = asks_place(request);
    return ring.serve(request);
  }))
    bench.now += milliseconds(300);
  EXPECT_EQ(bench.session.phase(), Phase::kDone) << bench.session.error().message;
  EXPECT_EQ(bench.session.state().executed, kBlocks);
}

/// An order is not acknowledged yet when the last block is counted.
TEST(ProvedEnd, AnOrderInTheLastMomentsProvesNoEnd) {
  RingBench bench(kBlocks);
  bench.ring.positions = program_end();
  bench.per_turn = 1;
  while (bench.ring.completed < kBlocks - 3) ASSERT_TRUE(bench.turn());
  bench.session.command({Order::kFeedOverride, 50}, bench.now);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(bench.turn([](FakeRing& ring, ModbusRequest request) {
      if (request.write_address == RingMap{}.mailbox) request.words.clear();
      return ring.serve(request);
    }));
    ASSERT_LT(bench.session.state().executed, kBlocks);
  }
  ASSERT_EQ(bench.ring.completed, kBlocks);
  bench.session.link_lost({Code::kLink, "the wire has gone"});
  expect_last_in_doubt(bench.session);
}

/// The last block comes to its end while the machine goes into a hold.
void hold_at_end(RingBench& bench) {
  bench.ring.positions = program_end();
  bench.per_turn = 1;
  while (bench.ring.completed < kBlocks - 1) ASSERT_TRUE(bench.turn());
  bench.session.command({Order::kHold}, bench.now);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(bench.turn());
  bench.ring.completed = kBlocks;
  bench.ring.used = 0;
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(bench.turn());
  ASSERT_EQ(bench.session.phase(), Phase::kHold);
}

TEST(ProvedEnd, AHoldAtTheEndProvesNoEnd) {
  RingBench bench(kBlocks);
  hold_at_end(bench);
  EXPECT_EQ(bench.session.state().executed, kBlocks - 1);
  EXPECT_EQ(bench.session.state().uncertain.first, kBlocks);
}

TEST(ProvedEnd, AStopAtTheEndLeavesTheLastBlockInDoubt) {
  RingBench bench(kBlocks);
  hold_at_end(bench);
  bench.session.command({Order::kStop}, bench.now);
  while (bench.turn()) continue;
  EXPECT_EQ(bench.session.phase(), Phase::kStopped);
  const std::string& why = bench.session.error().message;
  EXPECT_TRUE(has(why, "block 20 may have run")) << why;
}

/// Three blocks after the last move: coolant off, spindle off, end.
NumericBlock with_tail(std::uint64_t line) {
  NumericBlock block = block_at(line);
  if (line + 3 <= kBlocks) return block;
  block.op = BlockOp::kMCode;
  block.m_code = line + 2 == kBlocks ? 9 : line + 1 == kBlocks ? 5 : 2;
  return block;
}

TEST(ProvedEnd, WhatIsInDoubtBeginsWithTheLastMove) {
  for (const bool elsewhere : {false, true}) {
    RingBench bench(kBlocks);
    bench.block = with_tail;
    bench.per_turn = 1;
    bench.ring.positions = elsewhere ? Words(10, 0) : program_end();
    bool asked = false;
    while (!asked && bench.turn([&](FakeRing& ring, const ModbusRequest& request) {
      asked = asks_place(request);
      return ring.serve(request);
    }))
      ASSERT_LE(bench.session.state().executed, kBlocks - (asked ? 0 : 4)) << "a journal would keep it";
    if (!elsewhere) {
      ASSERT_EQ(bench.session.state().executed, kBlocks);
      continue;
    }
    for (int i = 0; i < 3; ++i) bench.turn();
    ModbusSession lost = bench.session;
    lost.link_lost({Code::kLink, "the wire has gone"});
    const std::string what = "blocks 17 to 20 may have run (lines 17 to 20 of the file)";
    EXPECT_TRUE(has(lost.error().message, what)) << lost.error().message;
    EXPECT_TRUE(has(lost.error().message, "earlier ones have,")) << lost.error().message;
    while (bench.turn()) continue;
    const std::string& why = bench.session.error().message;
    EXPECT_EQ(bench.session.state().executed, kBlocks - 4);
    EXPECT_TRUE(has(why, what)) << why;
    EXPECT_TRUE(has(why, "not at the program's end")) << why;
    EXPECT_FALSE(has(why, "earlier ones have,")) << why;
  }
}

TEST(ProvedEnd, APlaceThatCannotBeReadAtOnceIsAskedForAgain) {
  for (const int failures : {2, 1000}) {
    RingBench bench(kBlocks);
    bench.ring.positions = program_end();
    int asked = 0;
    while (bench.turn([&](FakeRing& ring, const ModbusRequest& request) {
      return asks_place(request) && asked++ < failures ? ModbusReply{4, {}} : ring.serve(request);
    }))
      continue;
    EXPECT_EQ(bench.session.phase(), failures == 2 ? Phase::kDone : Phase::kFault);
    EXPECT_LE(asked, 4);
  }
}

/// The sender died when all was executed and the place was not read: the next one reads it.
TEST(ProvedEnd, WhoGoesOnAfterTheLastBlockReadsThePlace) {
  for (const bool there : {true, false}) {
    RingBench bench(kBlocks);
    bench.ring.positions = program_end();
    run_to_place(bench);
    if (!there) bench.ring.positions = Words(10, 0);
    ModbusOptions options;
    options.total = kBlocks;
    options.session_id = 0x4321;
    options.attach = true;
    options.boot = bench.ring.boot;
    options.accepted = options.reserved = kBlocks;
    options.executed = 7;
    bool placed = false;
    ModbusSession next(options, bench.now);
    for (int turns = 0; turns < 1000 && !is_final(next.phase()); ++turns) {
      if (next.wants_work()) {
        ASSERT_EQ(*next.first_block(), kBlocks);
        for (std::uint64_t line = 1; line <= kBlocks; ++line) next.pass(block_at(line));
        next.end_of_program();
      }
      const std::string request(next.output(bench.now));
      bench.now = std::max(bench.now + milliseconds(1), request.empty() ? next.deadline() : Time{0});
      if (request.empty()) continue;
      next.sent(request.size());
      next.receive(pack_reply(bench.ring.serve(unpack_request(request))), bench.now);
      placed = placed || (there && asks_place(unpack_request(request)));
      ASSERT_TRUE(placed || next.state().executed < kBlocks);
    }
    EXPECT_EQ(next.phase(), there ? Phase::kDone : Phase::kFault) << next.error().message;
  }
}

TEST(ProvedEnd, ARingThatRefusesTheStopIsNotStopped) {
  RingBench bench(kBlocks);
  bench.per_turn = 0;
  bench.open();
  for (int i = 0; i < 5; ++i) bench.turn();
  bench.ring.keeps_session = true;
  bench.session.command({Order::kStop}, bench.now);
  for (int i = 0; i < 100 && bench.turn(); ++i) continue;
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_TRUE(has(bench.session.error().message, "refuses the stop")) << bench.session.error().message;
}

TEST(ProvedEnd, OfADripFeedThatHasSentItsLeaderOnlyNothingHasRun) {
  DripFormat format;
  for (const char* said : {"\x11", "\x11\x15"}) {
    DripSession session({100, 9600, format}, Time{0});
    session.receive(said, Time{0});
    session.command({Order::kStop}, Time{0});
    session.receive("", milliseconds(1));
    ASSERT_TRUE(is_final(session.phase()));
    EXPECT_EQ(session.state().sent, 0u);
    EXPECT_TRUE(has(session.error().message, "no line was sent")) << session.error().message;
  }
}

TEST(ProvedEnd, OfADripFeedEveryLineThatHasBegunToLeaveMayHaveRunAndNoOther) {
  DripFormat format;
  format.wait_for_start = false;
  constexpr std::size_t kPercent = 2, kLine = 5;  // with the end of the block
  for (const std::size_t bytes : {0u, 1u, 5u, 6u, 10u, 11u}) {
    DripSession session({100, 9600, format}, Time{0});
    for (std::uint64_t line = 1; line <= 20; ++line) session.push({line, "G1X1"});
    Time now{0};
    for (std::size_t left = kPercent + bytes; left > 0; now += milliseconds(1)) {
      const std::size_t taken = std::min(session.output(now).size(), left);
      session.sent(taken);
      left -= taken;
    }
    const std::size_t begun = (bytes + kLine - 1) / kLine;
    EXPECT_EQ(session.state().sent, begun) << bytes;
    EXPECT_EQ(session.state().uncertain.last, begun) << bytes;
  }
}

/// A drive that stands after each move, by its own word.
TEST(ProvedEnd, OfADriveWhatHasRunIsItsOwnWord) {
  DriveMap map;
  DriveSession session({3, map}, Time{0});
  Time now{0};
  std::uint64_t line = 1;
  for (int turns = 0; turns < 1000 && session.state().executed < 2; ++turns) {
    if (session.wants_work()) {
      NumericBlock block;
      block.op = BlockOp::kFeed;
      block.line = line;
      block.x = static_cast<double>(line++);
      block.feed = 600;
      session.push(block);
    }
    const std::string request(session.output(now));
    now += milliseconds(30);
    if (request.empty()) continue;
    session.sent(request.size());
    ModbusReply reply{kReplyOk, {}};
    if (unpack_request(request).read_count > 0) reply.words = {0};
    session.receive(pack_reply(reply), now);
  }
  ASSERT_EQ(session.state().executed, 2u) << session.error().message;
  session.link_lost({Code::kLink, "the wire has gone"});
  EXPECT_TRUE(has(session.error().message, "the drive's word")) << session.error().message;

  RunRecord record;
  record.total = record.executed = record.acknowledged = record.offered = record.reserved = 3;
  record.event = RunEvent::kExecuted;
  RunSubject subject;
  subject.total = 3;
  for (const LinkKind kind : {LinkKind::kDriveTcp, LinkKind::kGrbl}) {
    subject.link = kind;
    record.link = static_cast<std::uint8_t>(kind);
    JournalContent journal;
    journal.last = record;
    const ResumeDecision decision = decide_resume(journal, subject);
    EXPECT_EQ(decision.way, ResumeWay::kFinished);
    EXPECT_EQ(has(decision.text, "proves no more"), is_drive(kind)) << decision.text;
  }
}

TEST(ProvedEnd, CountsDecideAndNotWhetherLinesCanBeNamed) {
  SendState state;
  EXPECT_EQ(describe(state), "no line was sent");
  state.sent = state.executed = 5;
  EXPECT_EQ(describe(state), "all 5 blocks that were sent have run");
  state.sent = 8;
  EXPECT_EQ(describe(state), "blocks 6 to 8 may have run; earlier ones have, later ones have not");
  state.uncertain = {9, 12};
  EXPECT_TRUE(has(describe(state), "blocks 6 to 8 may have run (lines 9 to 12 of the file)"));
}

}  // namespace
}  // namespace tiltfeed
