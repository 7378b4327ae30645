// What a stop or a fault says of the lines that may have run holds the truth: lines that take no block of the
// planner, reports that come late, figures that the wire has changed, planned moves that were dropped.

#include <gtest/gtest.h>

#include "daemon/protocol/reprap_session.h"
#include "tests/peers/fake_grbl.h"
#include "tests/peers/line_run.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr std::string_view kHead = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nG1 F60\n";

/// Each place is stated `times` over, as programs of other makers do: only the first of these moves.
std::string repeated_places(int places, int times) {
  std::string text(kHead);
  for (int i = 1; i <= places; ++i)
    for (int k = 0; k < times; ++k) text += "X" + std::to_string(i) + "\n";
  return text + "M5\nM2\n";
}

/// What a run says has run, when its cable has come off or it was stopped in mid-run.
struct Said {
  std::uint64_t executed = 0, sent = 0;
  std::size_t truth = 0;
};

TEST(TrueRange, A1LinesThatTakeNoPlannerBlockHaveNotRun) {
  for (const int times : {1, 4, 10}) {
    LineRun run;
    double asked = 0.0;
    Said said;
    run.watch = [&](const SendState& state, double now, CommandQueue& queue) {
      if (asked > 0.0 || state.acknowledged < 40) return;
      asked = now;
      said.executed = state.executed;
      queue.push({Order::kAbort});
    };
    sim::GrblOptions firmware;
    firmware.planner = 15;
    const LineOutcome outcome = run_grbl(repeated_places(60, times), run, firmware);
    ASSERT_GT(asked, 0.0) << times;
    EXPECT_LE(said.executed, outcome.executed.size()) << times << ": lines are told as run that have not";
  }
}

TEST(TrueRange, A1RepRapLinesThatTakeNoPlannerBlockHaveNotRun) {
  LineRun run;
  Said said;
  run.watch = [&](const SendState& state, double, CommandQueue& queue) {
    if (said.sent > 0 || state.acknowledged < 180) return;
    said.executed = state.executed;
    said.sent = state.sent;
    queue.push({Order::kAbort});
  };
  const LineOutcome outcome = run_reprap(repeated_places(40, 15), run);
  ASSERT_GT(said.sent, 0u);
  EXPECT_LE(said.executed, outcome.executed.size());
}

/// With an emergency parser the planned moves are dropped: they are answered and have not run.
TEST(TrueRange, A1WhatM410HasDroppedHasNotRun) {
  for (const int window : {1, 4}) {
    LineRun run;
    run.profile.reprap_window = window;
    std::size_t told = 0;
    run.watch = [&](const SendState& state, double, CommandQueue& queue) {
      if (told == 0 && state.acknowledged > 30) told = 1, queue.push({Order::kStop});
    };
    const LineOutcome outcome = run_reprap(short_blocks(300, 0.2), run);
    ASSERT_FALSE(outcome.report);
    const std::string& why = outcome.report.error().message;
    EXPECT_EQ(why.find("all lines that were sent have run"), why.npos) << why;
    EXPECT_NE(why.find("may have run"), why.npos) << why;
    EXPECT_LE(outcome.last.executed, outcome.executed.size()) << why;
    EXPECT_GE(outcome.last.sent, outcome.executed.size()) << why;
    EXPECT_NE(outcome.said.find("M5*"), std::string::npos) << "its spindle turns on";
  }
}

/// A barrier is on its way already: its answer is not the end of the stop.
TEST(TrueRange, B8ARepRapStopAtTheEndLeavesNoSpindleOn) {
  LineRun run;
  bool told = false;
  run.watch = [&](const SendState& state, double, CommandQueue& queue) {
    if (!told && state.phase == Phase::kDrain) told = true, queue.push({Order::kStop});
  };
  const LineOutcome outcome = run_reprap(std::string(kHead) + "X1\nX2\n", run);
  ASSERT_TRUE(told);
  EXPECT_EQ(outcome.last.phase, Phase::kStopped);
  EXPECT_NE(outcome.said.find("M5*"), std::string::npos);
}

TEST(TrueRange, A1LinesThatHaveRunWereSent) {
  GrblBench bench({"G21", "M3S1000"});
  bench.open();
  for (int i = 0; i < 2; ++i) bench.fake.work(), bench.exchange();
  bench.session.command({Order::kStop}, bench.now);
  for (int i = 0; i < 20 && !is_final(bench.session.phase()); ++i) bench.exchange(milliseconds(250));
  const std::string why = bench.session.error().message;
  EXPECT_EQ(why.find("no line was sent"), why.npos) << why;
  EXPECT_NE(why.find("all 2 blocks that were sent have run"), why.npos) << why;
}

/// Two reports of before the hold in one reading: neither says what the reset has done.
TEST(TrueRange, B8AStopEndsWithTheBannerAndNotWithAnOldReport) {
  GrblBench bench({"G1X1", "G4P3", "G1X2", "G1X3"});
  bench.open();
  for (int i = 0; i < 3; ++i) bench.fake.work(), bench.exchange();
  bench.fake.silent_status = true;
  bench.session.command({Order::kStop}, bench.now);
  bench.talk();
  bench.now += milliseconds(250);
  const std::string old = "<Idle|MPos:1.000,0.000,0.000|Bf:15,128|WCO:0.000,0.000,0.000>\r\n";
  bench.say(old + old);
  EXPECT_NE(bench.session.phase(), Phase::kStopped) << "the reset has not even left";
  for (int i = 0; i < 20 && !is_final(bench.session.phase()); ++i) bench.exchange(milliseconds(50));
  EXPECT_EQ(bench.session.phase(), Phase::kStopped) << bench.session.error().message;
  EXPECT_GE(bench.fake.resets, 1);
}

/// Ln: of the last report with one figure changed: the line that is named is not the one that was cut.
TEST(TrueRange, A4OneChangedLineNumberDoesNotNarrowTheRange) {
  for (const int changed : {15, 5, 7}) {
    GrblOptions options;
    options.number_lines = true;
    GrblBench bench(numbered(20), FakeGrbl(1024), options);
    bench.say("GrblHAL 1.1f ['$' or '$HELP' for help]\r\n");
    bench.open();
    for (int i = 0; i < 200 && bench.fake.lines.size() < 20; ++i) bench.fake.work(), bench.exchange();
    bench.fake.silent_status = true;
    bench.session.command({Order::kStop}, bench.now);
    for (const int line : {5, changed, 5, 5}) {
      bench.exchange(milliseconds(250));
      if (bench.fake.resets > 0) break;
      bench.say("<Hold:0|MPos:4.500,0.000,0.000|Ln:" + std::to_string(line) + "|Bf:15,128>\r\n");
    }
    bench.exchange();
    ASSERT_EQ(bench.session.phase(), Phase::kStopped) << bench.session.error().message;
    EXPECT_EQ(bench.session.state().uncertain.first, 5u) << changed;
    EXPECT_EQ(bench.session.state().uncertain.last, 5u) << changed;
  }
}

}  // namespace
}  // namespace tiltfeed
