// GrblSession against a scripted controller in made-up time: windows, fragments, errors, alarms, resets, lost
// oks.

#include "daemon/protocol/grbl_session.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "daemon/wire/wire_text.h"
#include "tests/peers/fake_grbl.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

TEST(GrblSession, SendsEveryLineOnceInOrderAndProvesItByABarrier) {
  GrblBench bench(numbered(200));
  bench.finish();
  ASSERT_EQ(bench.session.phase(), Phase::kDone) << bench.session.error().message;
  std::vector<std::string> expected = numbered(200);
  expected.push_back("G4P0");
  EXPECT_EQ(bench.fake.lines, expected);
  EXPECT_EQ(bench.session.state().executed, 200u);
  EXPECT_EQ(bench.session.state().acknowledged, 200u);
}

TEST(GrblSession, IsNotDoneBeforeTheBarrierIsAnswered) {
  GrblBench bench(numbered(3));
  bench.open();
  for (int i = 0; i < 3; ++i) bench.fake.work();
  for (int i = 0; i < 10; ++i) bench.exchange();
  EXPECT_EQ(bench.session.phase(), Phase::kDrain);
  EXPECT_LT(bench.session.state().executed, 3u);
  bench.fake.work();
  bench.exchange();
  EXPECT_EQ(bench.session.phase(), Phase::kDrain) << "where the machine stands is not told yet";
  bench.exchange();
  EXPECT_EQ(bench.session.phase(), Phase::kDone);
}

TEST(GrblSession, NeverMoreOnItsWayThanTheWindow) {
  std::mt19937 random(7);
  const auto pick = [&](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
  for (int round = 0; round < 60; ++round) {
    const int buffer = pick(0, 1) ? 128 : pick(60, 1024);
    std::vector<std::string> program;
    for (int i = 0, count = pick(1, 300); i < count; ++i)
      program.push_back("G1X" + std::string(static_cast<std::size_t>(pick(1, 50)), '1'));
    GrblBench bench(program, FakeGrbl(buffer));
    bench.fake.offsets = false;  // it does not count so far
    std::string to_controller, to_session;
    for (int i = 0; i < 200000 && bench.session.phase() != Phase::kDone; ++i) {
      ASSERT_NE(bench.session.phase(), Phase::kFault) << bench.session.error().message << " round " << round;
      bench.feed();
      const std::string_view out = bench.session.output(bench.now);
      const std::size_t taken = std::min<std::size_t>(out.size(), static_cast<std::size_t>(pick(0, 40)));
      to_controller += out.substr(0, taken);
      bench.session.sent(taken);
      const std::size_t moved =
          std::min<std::size_t>(to_controller.size(), static_cast<std::size_t>(pick(0, 30)));
      bench.fake.receive(to_controller.substr(0, moved));
      to_controller.erase(0, moved);
      for (int k = pick(0, 3); k > 0; --k) bench.fake.work();
      to_session += bench.fake.replies;
      bench.fake.replies.clear();
      const std::size_t came = std::min<std::size_t>(to_session.size(), static_cast<std::size_t>(pick(0, 9)));
      const std::string bytes = to_session.substr(0, came);
      to_session.erase(0, came);
      bench.session.receive(bytes, bench.now);
      bench.now += milliseconds(pick(0, 3));
      ASSERT_LE(bench.session.in_flight_bytes(), static_cast<std::size_t>(buffer - 1));
    }
    ASSERT_EQ(bench.session.phase(), Phase::kDone) << "round " << round << " buffer " << buffer;
    program.push_back("G4P0");
    ASSERT_EQ(bench.fake.lines, program) << "round " << round;
  }
}

TEST(GrblSession, BytesAtTheControllerNeverExceedItsBuffer) {
  GrblBench bench(numbered(500), FakeGrbl(100));
  bench.finish();
  EXPECT_EQ(bench.session.phase(), Phase::kDone);
  EXPECT_LE(bench.fake.most_unanswered, 99u);
  EXPECT_GT(bench.fake.most_unanswered, 80u) << "the window is not used";
}

TEST(GrblSession, SaysWhenTheControllerHasRunOut) {
  GrblBench bench(numbered(500));
  bench.open();
  EXPECT_FALSE(bench.session.state().starved) << "it has taken nothing yet";
  for (int i = 0; i < 3; ++i) bench.fake.work();
  const auto with_room = [&](const std::string& room) {
    bench.fake.room = room;
    for (const int polls = bench.fake.polls; bench.fake.polls < polls + 2;) bench.exchange(milliseconds(10));
    return bench.session.state().starved;
  };
  EXPECT_EQ(with_room("15,128"), true);
  EXPECT_EQ(with_room("14,128"), false) << "a block is planned";
  EXPECT_EQ(with_room("15,20"), false) << "lines wait behind one that lasts";
  EXPECT_EQ(with_room("15,120"), true) << "a part of a line has come";
  bench.session.command({Order::kHold}, bench.now);
  EXPECT_FALSE(with_room("15,128"));
}

TEST(GrblSession, UsesTheRealReceiveBuffer) {
  GrblBench large(numbered(1000), FakeGrbl(1024));
  large.open();
  EXPECT_EQ(large.session.window(), 1023u);
  EXPECT_GT(large.fake.unanswered, 800u);
  GrblBench unknown(numbered(10), FakeGrbl(0, false));  // no [OPT:], Bf says 128
  for (int i = 0; i < 400 && is_opening(unknown.session.phase()); ++i) unknown.exchange();
  EXPECT_EQ(unknown.session.window(), 127u);
  GrblOptions given;
  given.receive_buffer = 64;
  GrblBench told(numbered(10), FakeGrbl(1024), given);
  told.open();
  EXPECT_EQ(told.session.window(), 64u);
}

TEST(GrblSession, RepliesMayComeByteByByte) {
  GrblBench bench(numbered(20));
  for (int i = 0; i < 10000 && bench.session.phase() != Phase::kDone; ++i) {
    bench.talk();
    bench.fake.work();
    const std::string in = std::move(bench.fake.replies);
    bench.fake.replies.clear();
    for (const char c : in) bench.session.receive(std::string(1, c), bench.now);
    bench.now += milliseconds(1);
  }
  EXPECT_EQ(bench.session.phase(), Phase::kDone);
}

TEST(GrblSession, OneBadByte_IsNoTextInAMessage) {
  GrblBench bench(numbered(20));
  bench.open();
  bench.say("o\xeb\x01\r\n");
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_NE(bench.session.error().message.find("'o?"
                                               "?'"),
            std::string::npos)
      << bench.session.error().message;
  GrblBench opening(numbered(20));
  opening.fake.silent_status = true;
  opening.exchange();
  opening.say("\xeb\xeb\r\n");
  for (int i = 0; i < 11; ++i) opening.exchange(seconds(1));
  EXPECT_NE(opening.session.error().message.find("'?"
                                                 "?'"),
            std::string::npos)
      << opening.session.error().message;
  bench.say("<Hold:\xeb|MPos:0,0,0>\r\n");
  for (const char c : bench.session.state().machine) EXPECT_GE(c, ' ');
  EXPECT_EQ(valid_text("a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80"), "a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80");
  EXPECT_EQ(valid_text("\xeb"
                       "b\xc0\xaf\xed\xa0\x80\xf4\x90\x80\x80\xc3"),
            "?b" + std::string(10, '?'));
}

TEST(GrblSession, AFragmentIsNeverAnOk) {
  for (const char* fragment : {"o\r\n", "k\r\n", "ok[]\r\n", "o*\r\n", "okok\r\n", " ok\r\n", "OK\r\n"}) {
    GrblBench bench(numbered(20));
    bench.open();
    bench.say(fragment);
    EXPECT_EQ(bench.session.state().acknowledged, 0u) << fragment;
    EXPECT_EQ(bench.session.phase(), Phase::kFault) << fragment;
  }
  GrblBench bench(numbered(50));
  bench.open();
  bench.say("o");
  EXPECT_EQ(bench.session.state().acknowledged, 0u);
  bench.say("k");
  EXPECT_EQ(bench.session.state().acknowledged, 0u);
  bench.say("\r\n");
  EXPECT_EQ(bench.session.state().acknowledged, 1u);
  bench.say(
      "<Id|MPo\r\n[MSG:Caution]\r\n$10=1\r\n\r\n");  // damaged report and information: neither ok nor fault
  EXPECT_EQ(bench.session.state().acknowledged, 1u);
  EXPECT_EQ(bench.session.phase(), Phase::kRun);
}

TEST(GrblSession, AnErrorNamesItsLineAndHoldsTheMachine) {
  GrblBench bench(numbered(50));
  bench.open();
  bench.fake.work();
  bench.fake.work();
  bench.fake.work("error:20");
  bench.listen();
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  const std::string& message = bench.session.error().message;
  EXPECT_EQ(bench.session.error().code, Code::kLink);
  EXPECT_NE(message.find("error:20"), std::string::npos) << message;
  EXPECT_NE(message.find("line 3 'G1X3'"), std::string::npos) << message;
  EXPECT_NE(message.find("lines 1 to "), std::string::npos) << message;
  EXPECT_EQ(bench.session.output(bench.now), "!");
  EXPECT_FALSE(bench.session.wants_work());
}

TEST(GrblSession, AnAlarmOrARestartIsAFault) {
  for (const std::string text : {"ALARM:1\r\n", "\r\nGrbl 1.1h ['$' for help]\r\n",
                                 "GrblHAL 1.1f ['$' for help]\r\n", "<Alarm|MPos:0,0,0|Bf:15,128>\r\n"}) {
    GrblBench bench(numbered(50));
    bench.open();
    bench.say(text);
    const bool alarm = text.find("larm") != text.npos || text.find("ALARM") != text.npos;
    EXPECT_EQ(bench.session.phase(), alarm ? Phase::kAlarm : Phase::kFault) << text;
    EXPECT_TRUE(bench.session.output(bench.now).empty()) << "nothing more may be sent after " << text;
    EXPECT_NE(bench.session.error().message.find("may have run"), std::string::npos);
  }
}

TEST(GrblSession, AnOkTooManyIsAFault) {
  GrblBench bench(numbered(50));
  bench.open();
  bench.feed();
  const std::string_view out = bench.session.output(bench.now);
  const std::size_t on_the_wire = bench.session.state().sent;
  for (std::size_t i = 0; i < on_the_wire; ++i) bench.say("ok\r\n");
  EXPECT_EQ(bench.session.phase(), Phase::kRun);
  EXPECT_EQ(bench.session.state().acknowledged, on_the_wire);
  bench.feed();
  bench.say("ok\r\n");  // the next line is ready but has not left yet
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_TRUE(out.empty());
}

TEST(GrblSession, C17ALineOfWhichTheWireTookAPartMayHaveRun) {
  for (const std::size_t taken : {0u, 1u, 4u, 5u}) {  // of "G1X1\n"
    GrblBench bench(numbered(1));
    for (int i = 0; i < 20 && is_opening(bench.session.phase()); ++i) bench.exchange();
    bench.feed();
    ASSERT_TRUE(bench.session.output(bench.now).starts_with("G1X1\n")) << bench.session.output(bench.now);
    bench.session.sent(taken);
    bench.session.link_lost({Code::kLink, "unplugged"});
    EXPECT_EQ(bench.session.state().sent, taken > 0 ? 1u : 0u) << taken;
    EXPECT_EQ(bench.session.state().uncertain.last, taken > 0 ? 1u : 0u) << taken;
  }
}

TEST(GrblSession, ALostOkIsAFaultAndNeverGuessed) {
  GrblBench bench(numbered(2));
  bench.open();
  bench.fake.work();
  bench.fake.replies.clear();  // lost
  for (int i = 0; i < 400 && bench.session.phase() != Phase::kFault; ++i) {
    bench.fake.work();
    bench.exchange(milliseconds(100));
  }
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_NE(bench.session.error().message.find("no progress"), std::string::npos)
      << bench.session.error().message;
  EXPECT_GE(bench.now, seconds(10));
}

TEST(GrblSession, AWithheldOkIsWaitedForWhileTheMachineHoldsOrMovesOrDwells) {
  GrblBench hold(numbered(50));
  hold.open();
  hold.fake.state = "Hold:0";
  for (int i = 0; i < 1000; ++i) hold.exchange(seconds(1));
  EXPECT_EQ(hold.session.phase(), Phase::kHold) << hold.session.error().message;
  hold.fake.state = "Idle";
  hold.finish();
  EXPECT_EQ(hold.session.phase(), Phase::kDone) << hold.session.error().message;

  GrblBench moving(numbered(50));
  moving.fake.offsets = false;  // its places are not those of the lines
  moving.open();
  for (int i = 0; i < 1000; ++i) {
    ++moving.fake.position;
    moving.exchange(seconds(1));
  }
  EXPECT_EQ(moving.session.phase(), Phase::kRun) << moving.session.error().message;

  GrblBench dwelling({"G4P60", "G1X1"});  // Idle is shown during a dwell
  dwelling.open();
  for (int i = 0; i < 65; ++i) dwelling.exchange(seconds(1));
  EXPECT_NE(dwelling.session.phase(), Phase::kFault) << dwelling.session.error().message;
  for (int i = 0; i < 10; ++i)
    dwelling.exchange(seconds(1));  // the 60 s and the 10 s of any other line are over
  EXPECT_EQ(dwelling.session.phase(), Phase::kFault);
}

TEST(GrblSession, ASilentControllerIsAFault) {
  GrblBench bench(numbered(50));
  bench.open();
  bench.fake.silent_status = true;
  const Time from = bench.now;
  while (bench.session.phase() == Phase::kRun && bench.now < seconds(60)) bench.exchange(milliseconds(50));
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_LE(bench.now - from, seconds(6));
}

TEST(GrblSession, NothingFollowsAStopUntilItIsAnswered) {
  GrblBench bench({"G1X1", "M0", "G1X2"});
  bench.open();
  for (int i = 0; i < 20; ++i) bench.exchange();
  EXPECT_EQ(bench.session.state().sent, 1u);
  bench.fake.work();
  for (int i = 0; i < 20; ++i) bench.exchange();
  EXPECT_EQ(bench.session.state().sent, 2u);
  bench.fake.work();
  bench.finish();
  EXPECT_EQ(bench.fake.lines, (std::vector<std::string>{"G1X1", "M0", "G1X2", "G4P0"}));
}

TEST(GrblSession, OldRepliesAtTheOpeningCountForNothing) {
  GrblBench bench(numbered(20));
  bench.say("ok\r\nok\r\nerror:9\r\nets Jul 29 2019 12:21:46\r\nALARM:3\r\n");
  bench.open();
  EXPECT_EQ(bench.session.state().acknowledged, 0u);
  bench.finish();
  EXPECT_EQ(bench.session.phase(), Phase::kDone);
}

TEST(GrblSession, AnOldOkAfterTheProbeDoesNotEndIt) {
  GrblBench bench(numbered(20), FakeGrbl(1024));
  bench.fake.withhold = true;
  while (!bench.fake.waiting()) bench.exchange();
  bench.say("ok\r\n");  // somebody else's
  EXPECT_TRUE(is_opening(bench.session.phase()));
  bench.fake.withhold = false;
  bench.fake.work();
  bench.open();
  EXPECT_EQ(bench.session.window(), 1023u);
  bench.finish();
  EXPECT_EQ(bench.session.phase(), Phase::kDone) << bench.session.error().message;
}

TEST(GrblSession, AFragmentThatSomebodyLeftSpoilsOneProbeOnly) {
  GrblBench bench(numbered(20));
  bench.fake.withhold = true;
  bench.exchange();
  bench.exchange();
  bench.fake.work("error:1");
  bench.fake.replies = "error:1\r\n";
  bench.fake.withhold = false;
  bench.open();
  EXPECT_EQ(bench.session.window(), 127u);
}

TEST(GrblSession, RefusesToStartInAlarmInMotionOrWithoutAnswer) {
  GrblBench alarm(numbered(3));
  alarm.fake.state = "Alarm";
  alarm.exchange();
  EXPECT_EQ(alarm.session.phase(), Phase::kAlarm);
  GrblBench busy(numbered(3));
  busy.fake.state = "Run";
  while (is_opening(busy.session.phase()) && busy.now < seconds(60)) busy.exchange(milliseconds(50));
  EXPECT_NE(busy.session.error().message.find("Run"), std::string::npos);
  GrblBench dead(numbered(3));
  dead.fake.silent_status = true;
  while (is_opening(dead.session.phase()) && dead.now < seconds(60)) dead.exchange(milliseconds(50));
  EXPECT_NE(dead.session.error().message.find("no answer"), std::string::npos);
  EXPECT_TRUE(alarm.fake.lines.empty() && busy.fake.lines.empty() && dead.fake.lines.empty());
}

TEST(GrblSession, RefusesALineThatTheControllerCannotTake) {
  GrblBench bench({"G1X1", "G1X" + std::string(90, '1')});  // Grbl 1.1h takes 79
  for (int i = 0; i < 20; ++i) bench.exchange();
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_EQ(bench.session.error().code, Code::kLimit);
  EXPECT_NE(bench.session.error().message.find("line 2"), std::string::npos);
  EXPECT_TRUE(bench.fake.lines.empty());
}

TEST(GrblSession, PollsTheStatusAboutFiveTimesASecond) {
  GrblBench bench(numbered(1));
  bench.open();
  const int before = bench.fake.polls;
  for (int i = 0; i < 1000; ++i) bench.exchange(milliseconds(5));
  EXPECT_NEAR(bench.fake.polls - before, 25, 2);
}

TEST(GrblSession, StopHoldsThenResetsTheMachineThatStands) {
  GrblBench bench(numbered(50));
  bench.open();
  bench.session.command({Order::kStop}, bench.now);
  EXPECT_EQ(bench.session.phase(), Phase::kStop);
  for (int i = 0; i < 1000 && !is_final(bench.session.phase()); ++i) bench.exchange();
  EXPECT_EQ(bench.session.phase(), Phase::kStopped);
  EXPECT_EQ(bench.session.error().code, Code::kCancelled);
  EXPECT_NE(bench.session.error().message.find("stopped on request"), std::string::npos);
  EXPECT_EQ(bench.fake.holds, 1);
  EXPECT_EQ(bench.fake.resets, 1);
}

}  // namespace
}  // namespace tiltfeed
