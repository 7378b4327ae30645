// The phases as a table, and what an operator's orders do to simulated machines: hold, resume, stop, abort,
// overrides, check, tool change; the drip feed; a million-fault campaign has them, too
// (ring_campaign_test.cpp).

#include <gtest/gtest.h>

#include <set>

#include "daemon/protocol/drip_session.h"
#include "daemon/protocol/reprap_session.h"
#include "tests/peers/fake_grbl.h"
#include "tests/peers/line_run.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr int kPhases = static_cast<int>(Phase::kFault) + 1, kEvents = static_cast<int>(Event::kFailed) + 1;

// (session.h, property 1)
TEST(Phases, FinalPhasesHaveNoWayOutAndTheOthersCanFail) {
  for (int p = 0; p < kPhases; ++p) {
    const auto phase = static_cast<Phase>(p);
    for (int e = 0; e < kEvents && is_final(phase); ++e)
      EXPECT_FALSE(next_phase(phase, static_cast<Event>(e))) << phase_name(phase);
    if (is_final(phase)) continue;
    EXPECT_EQ(next_phase(phase, Event::kFailed), Phase::kFault);
    EXPECT_EQ(next_phase(phase, Event::kAlarm), Phase::kAlarm);
  }
}

// (session.h, property 2)
TEST(Phases, EveryPhaseIsReachedAndDoneOnlyThroughDrain) {
  std::set<Phase> reached{Phase::kConnect};
  for (int round = 0; round < kPhases; ++round)
    for (const Phase phase : std::set<Phase>(reached))
      for (int e = 0; e < kEvents; ++e)
        if (const auto next = next_phase(phase, static_cast<Event>(e))) {
          reached.insert(*next);
          EXPECT_TRUE(*next != Phase::kDone || phase == Phase::kDrain) << phase_name(phase);
          EXPECT_TRUE(phase != Phase::kHold || *next != Phase::kDrain) << "only a resume ends a hold";
        }
  EXPECT_EQ(reached.size(), static_cast<std::size_t>(kPhases));
}

// (session.h, property 3)
TEST(Phases, WhatIsObeyedHasItsTransition) {
  // The events that the orders lead to: a session that obeys never asks for a transition that is not there.
  for (int p = 0; p < kPhases; ++p) {
    const auto phase = static_cast<Phase>(p);
    const auto obeyed = [&](Order order) { return answer_to(order, phase) == Answer::kObey; };
    EXPECT_TRUE(!obeyed(Order::kHold) || next_phase(phase, Event::kHeld)) << phase_name(phase);
    EXPECT_TRUE(!obeyed(Order::kStop) || next_phase(phase, Event::kStopAsked)) << phase_name(phase);
    const Event resumed = phase == Phase::kHold ? Event::kResumed : Event::kOperatorDone;
    EXPECT_TRUE(!obeyed(Order::kResume) || next_phase(phase, resumed)) << phase_name(phase);
    EXPECT_EQ(obeyed(Order::kAbort), !is_opening(phase) && !is_final(phase)) << phase_name(phase);
    for (const Order order : {Order::kStop, Order::kAbort}) {
      EXPECT_EQ(answer_to(order, phase) == Answer::kEnd, is_opening(phase)) << phase_name(phase);
      EXPECT_TRUE(!is_opening(phase) || next_phase(phase, Event::kStood) == Phase::kStopped);
    }
    for (int order = 0; order <= static_cast<int>(Order::kSpindleOverride) && is_final(phase); ++order)
      EXPECT_EQ(answer_to(static_cast<Order>(order), phase), Answer::kIgnore) << phase_name(phase);
  }
  EXPECT_EQ(answer_to(Order::kResume, Phase::kRun), Answer::kNotHeld);
  EXPECT_EQ(answer_to(Order::kHold, Phase::kIdentify), Answer::kNothingYet);
}

TEST(Orders, FeedHoldActsWithinAStatusIntervalWhateverIsBuffered) {
  for (const double each : {0.002, 0.02, 2.0}) {
    LineRun run;
    double asked = 0.0, held = 0.0;
    bool resumed = false;
    run.watch = [&](const SendState& state, double now, CommandQueue& queue) {
      if (asked == 0.0 && state.acknowledged > 40) asked = now, queue.push({Order::kHold});
      if (asked > 0.0 && held == 0.0 && state.machine.starts_with("Hold")) held = now;
      if (held > 0.0 && now > held + 1.0 && !resumed) resumed = true, queue.push({Order::kResume});
    };
    const LineOutcome outcome = run_grbl(short_blocks(300, each), run);
    EXPECT_TRUE(outcome.whole()) << outcome.report.error().message;
    ASSERT_GT(held, 0.0);
    EXPECT_LE(held - asked, 0.4) << "one interval to act, and the next report to say so";
  }
}

TEST(Orders, ALostHoldIsAskedForAgain) {
  GrblBench bench(numbered(50));
  bench.open();
  bench.session.command({Order::kHold}, bench.now);
  bench.session.sent(bench.session.output(bench.now).size());  // lost on the way
  for (int i = 0; i < 1000 && bench.fake.holds == 0; ++i) bench.exchange();
  EXPECT_EQ(bench.fake.holds, 1);
  EXPECT_LE(bench.now, milliseconds(700));
  EXPECT_EQ(bench.session.phase(), Phase::kHold);
}

// (session.h, property 4)
TEST(Orders, InAHoldNoLineIsTakenFromTheProgram) {
  GrblBench bench(numbered(50));
  bench.open();
  bench.session.command({Order::kHold}, bench.now);
  EXPECT_FALSE(bench.session.wants_work());
  for (int i = 0; i < 300; ++i) bench.fake.work(), bench.exchange(milliseconds(10));
  const std::size_t taken = bench.fake.lines.size();
  EXPECT_LT(taken, 50u);
  EXPECT_EQ(bench.fake.resumes, 0) << "never by itself";
  bench.session.command({Order::kResume}, bench.now);
  bench.finish();
  EXPECT_EQ(bench.session.phase(), Phase::kDone) << bench.session.error().message;
}

TEST(Orders, StopKeepsThePositionAndTellsWhatMayHaveRun) {
  LineRun run;
  run.watch = [](const SendState& state, double, CommandQueue& queue) {
    if (state.acknowledged > 100) queue.push({Order::kStop});
  };
  const LineOutcome outcome = run_grbl(short_blocks(2000, 0.01), run);
  ASSERT_FALSE(outcome.report);
  EXPECT_EQ(outcome.report.error().code, Code::kCancelled);
  EXPECT_EQ(outcome.last.phase, Phase::kStopped);
  EXPECT_TRUE(outcome.in_order());
  EXPECT_GE(outcome.executed.size(), outcome.last.executed);
  EXPECT_LT(outcome.executed.size(), 600u);
  EXPECT_EQ(outcome.report.error().message.find("ALARM"), std::string::npos);
}

TEST(Orders, AbortResetsAtOnce) {
  LineRun run;
  run.watch = [](const SendState& state, double, CommandQueue& queue) {
    if (state.acknowledged > 100) queue.push({Order::kAbort});
  };
  const LineOutcome outcome = run_grbl(short_blocks(2000, 0.01), run);
  ASSERT_FALSE(outcome.report);
  EXPECT_NE(outcome.report.error().message.find("home it first"), std::string::npos);
  EXPECT_EQ(outcome.said.back(), 0x18);
}

TEST(Orders, OverridesReachWhatWasAskedFor) {
  LineRun run;
  int seen = 0;
  run.watch = [&](const SendState& state, double, CommandQueue& queue) {
    if (state.phase == Phase::kRun && seen == 0) seen = 1, queue.push({Order::kFeedOverride, 137});
    if (state.feed_override == 137) seen = 2;
  };
  EXPECT_TRUE(run_grbl(short_blocks(300, 0.05), run).whole());
  EXPECT_EQ(seen, 2);
}

TEST(Orders, CheckFindsTheErrorBeforeAnythingMoves) {
  LineRun run;
  run.options.check = true;
  std::string program = short_blocks(300, 0.01);
  const LineOutcome good = run_grbl(program, run);
  EXPECT_TRUE(good.whole()) << good.report.error().message << good.executed.size();
  const std::size_t at = program.find("G1X2.0000");
  program.insert(at, "G2X3Y3I1F60\n");
  const LineOutcome bad = run_grbl(program, run);
  ASSERT_FALSE(bad.report);
  EXPECT_TRUE(bad.executed.empty());
  EXPECT_NE(bad.report.error().message.find("nothing has moved"), std::string::npos)
      << bad.report.error().message;
  EXPECT_NE(bad.report.error().message.find("G2X3"), std::string::npos) << bad.report.error().message;
}

TEST(Orders, LineNumbersSayWhatRuns) {
  LineRun run;
  run.profile.line_numbers = true;
  std::uint64_t line = 0;
  run.watch = [&](const SendState& state, double, CommandQueue&) { line = std::max(line, state.line); };
  const LineOutcome outcome = run_grbl(short_blocks(200, 0.02), run);
  EXPECT_TRUE(outcome.whole()) << outcome.report.error().message;
  EXPECT_GT(line, 150u);
}

/// Marlin reads nothing behind M0 but what its emergency parser picks out, and M410 does not end that wait.
TEST(RepRap, B8AStopEndsTheWaitOfM0) {
  for (const bool parser : {true, false}) {
    RepRapSession session({2, 1}, Time{0});
    Time now{0};
    std::string said;
    bool waits = false, pressed = false;
    for (int i = 0; i < 4000 && !is_final(session.phase()); ++i, now += milliseconds(100)) {
      if (session.wants_work()) session.push({1, "M0", true, true, 0.0});
      if (session.phase() == Phase::kToolChange && waits) session.command({Order::kStop}, now);
      const std::string out(session.output(now));
      session.sent(out.size());
      said += out;
      std::string in = i % 20 == 0 ? "echo:busy: paused for user\n" : "";
      if (out.find("M110") != out.npos) in = "ok\n";
      if (out.find("M115") != out.npos)
        in = std::string("FIRMWARE_NAME:Marlin\nCap:EMERGENCY_PARSER:") + (parser ? "1" : "0") + "\nok\n";
      if (out.find("M0*") != out.npos) waits = true;
      // By the host's word, or by the button at the machine a minute later.
      pressed = pressed || (parser ? out.find("M108\n") != out.npos : i == 600);
      if (waits && pressed) in = "ok\n", waits = false;
      for (const char* last : {"M5*", "M9*", "M400"})
        if (out.find(last) != out.npos) in = "ok\n";
      session.receive(in, now);
      if (session.phase() == Phase::kStop && waits && !parser) {
        EXPECT_NE(session.state().refused.find("press its button"), std::string::npos);
      }
    }
    EXPECT_EQ(session.phase(), Phase::kStopped) << parser << ": " << session.error().message;
    EXPECT_EQ(said.find("M108") != said.npos, parser);
    if (parser) {
      EXPECT_LT(now, seconds(60));
    }
  }
}

TEST(RepRap, ExactlyOnceUnderResendsInAWindow) {
  std::uint64_t faults = 0;
  for (int seed = 1; seed <= 12; ++seed) {
    LineRun run;
    run.profile.reprap_window = 1 + seed % 4;
    run.faults = "seed " + std::to_string(seed) +
                 "\ndrop p=0.0004\nlose-ok p=0.01\nresend-storm p=0.2 value=3\ndelay p=0.0002 for=0.3";
    sim::RepRapOptions firmware;
    firmware.advanced_ok = seed % 2 == 0;
    const LineOutcome outcome = run_reprap(short_blocks(200, 0.004), run, firmware);
    EXPECT_TRUE(outcome.whole()) << "seed " << seed << ": "
                                 << (outcome.report ? "blocks" : outcome.report.error().message);
    faults += outcome.faults;
  }
  EXPECT_GT(faults, 40u);
}

TEST(RepRap, AsksForItsCapabilities) {
  sim::RepRapOptions firmware;
  firmware.advanced_ok = true;
  LineRun run;
  run.latency = 0.008;
  const LineOutcome four = run_reprap(short_blocks(300, 0.001), run, firmware);
  ASSERT_TRUE(four.whole());
  firmware.advanced_ok = false;
  const LineOutcome one = run_reprap(short_blocks(300, 0.001), run, firmware);
  ASSERT_TRUE(one.whole());
  EXPECT_LT(four.seconds, one.seconds) << "the window is not used";
}

TEST(Drip, TheControlGetsLeaderPercentProgramPercentTrailer) {
  for (const EndOfBlock end : {EndOfBlock::kLf, EndOfBlock::kCrLf, EndOfBlock::kCr, EndOfBlock::kLfCrCr}) {
    LineRun run;
    run.profile.drip.end_of_block = end;
    run.profile.drip.leader = 20;
    run.profile.drip.trailer = 10;
    sim::DripControlOptions control;
    control.start_at = 3.0;
    const LineOutcome outcome = run_drip(short_blocks(60, 0.05), run, control);
    ASSERT_TRUE(outcome.report) << outcome.report.error().message;
    EXPECT_FALSE(outcome.report->executed) << "nothing is proved on this link";
    EXPECT_EQ(outcome.executed.size(), outcome.program.size());
    EXPECT_TRUE(outcome.in_order());
    EXPECT_EQ(outcome.said.substr(0, 21), std::string(20, '\0') + "%");
    EXPECT_EQ(outcome.said.substr(outcome.said.size() - 10), std::string(10, '\0'));
    EXPECT_GT(outcome.seconds, 3.0) << "sent before the control's DC1";
  }
}

TEST(Drip, AStuckXoffIsWaitedForAndCanBeStopped) {
  LineRun run;
  run.watch = [](const SendState& state, double now, CommandQueue& queue) {
    if (state.machine == "XOFF" && now > 500.0) queue.push({Order::kStop});
  };
  sim::DripControlOptions control;
  control.buffer = 256;
  control.go_free = 250;
  const LineOutcome outcome =
      run_drip("G21G90G94\nG0X0Y0Z0A0C0\nM0\n" + short_blocks(100, 0.01).substr(40), run, control);
  ASSERT_FALSE(outcome.report);
  EXPECT_EQ(outcome.last.phase, Phase::kStopped);
  EXPECT_GT(outcome.seconds, 500.0);
}

/// A session and what it gives to the wire in a second, with `said` by the control on the way.
std::string drip_second(const DripFormat& format, std::string_view said) {
  DripSession session({100, 9600, format}, Time{0});
  std::string wire;
  for (Time now{0}; now < std::chrono::seconds(1); now += std::chrono::milliseconds(1)) {
    while (session.wants_work()) session.push({1, "G1X1.25Y2.5Z3.75F600"});
    if (now == std::chrono::milliseconds(500)) session.receive(said, now);
    const std::string out(session.output(now));
    wire += out;
    session.sent(out.size());
  }
  return wire;
}

TEST(Drip, OtherBytesThanDc1AndDc3AndTheDriversHandshake) {
  DripFormat format;
  format.wait_for_start = false;
  const std::size_t whole = drip_second(format, "").size();
  EXPECT_NEAR(static_cast<double>(whole), 9600.0 / 11.0, 15.0);
  EXPECT_NEAR(static_cast<double>(drip_second(format, "\x13").size()), static_cast<double>(whole) / 2.0,
              15.0);
  EXPECT_EQ(drip_second(format, "\x14").size(), whole) << "DC4 is not this control's stop";
  format.xoff = 0x14;
  EXPECT_EQ(drip_second(format, "\x13").size(), whole);
  EXPECT_LT(drip_second(format, "\x14").size(), whole * 6 / 10);
  // With RTS/CTS the driver stops; bytes say nothing.
  format.flow = FlowControl::kRtsCts;
  EXPECT_EQ(drip_second(format, "\x14").size(), whole);
  // The control's own start byte, and nothing before it.
  format.wait_for_start = true;
  format.xon = 0x12;
  EXPECT_EQ(drip_second(format, "\x11").size(), 0u);
  EXPECT_GT(drip_second(format, "\x12").size(), 0u);
}

TEST(Drip, AnAlarmOrAResetOfTheControlIsAFault) {
  for (const char* fault : {"alarm at=1", "reset at=1"}) {
    LineRun run;
    run.faults = fault;
    const LineOutcome outcome = run_drip(short_blocks(200, 0.01), run);
    ASSERT_FALSE(outcome.report) << fault;
    EXPECT_EQ(outcome.last.phase, Phase::kFault);
    EXPECT_LE(outcome.executed.size(), outcome.last.sent);
  }
}

}  // namespace
}  // namespace tiltfeed
