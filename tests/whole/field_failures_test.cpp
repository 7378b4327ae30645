// The failures that senders have had in the field, by the numbers of the list in daemon/stream/README.md,
// against simulated firmware in made-up time. 15, 16 and 26 are with the scripted controller, 17 and 24 in
// serial_link_test.cpp.

#include <gtest/gtest.h>

#include "daemon/protocol/reprap_session.h"
#include "tests/peers/fake_grbl.h"
#include "tests/peers/line_run.h"
#include "tests/peers/ring_campaign.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

/// The line `prefix` of `said` comes after byte `from`.
bool says_after(const LineOutcome& outcome, std::size_t from, char byte) {
  return outcome.said.find(byte, from) != outcome.said.npos;
}

/// What a link that proves nothing owes after a fault: the executed blocks are a begin of the program, the
/// lines said to be surely executed are, those said to be surely not executed are not, and nobody resumed.
void expect_honest_fault(const LineOutcome& outcome) {
  ASSERT_FALSE(outcome.report);
  EXPECT_TRUE(outcome.in_order());
  EXPECT_FALSE(says_after(outcome, 0, '~')) << "resumed by itself";
  std::uint64_t newest = 0;
  for (const sim::Block& block : outcome.executed) newest = std::max<std::uint64_t>(newest, block.line);
  EXPECT_LE(newest, outcome.last.uncertain.last) << outcome.report.error().message;
}

TEST(FieldFailures, F01_StarvedPlannerOnShortSegments) {
  // A block has 44 bytes: 3.8 ms at 115200. What can be sent in time never starves the planner.
  const LineOutcome fed = run_grbl(short_blocks(2000, 0.005), {});
  ASSERT_TRUE(fed.whole()) << fed.report.error().message;
  EXPECT_LT(fed.starved, 0.02) << "more than the beginning";
  const LineOutcome hungry = run_grbl(short_blocks(2000, 0.002), {});
  EXPECT_GT(hungry.starved, 1.0) << "this cannot be sent in time: the measurement is wrong";
}

TEST(FieldFailures, F02_ReplyLatencyOf16Milliseconds) {
  LineRun run;
  run.latency = 0.016;
  const LineOutcome large = run_grbl(short_blocks(2000, 0.005), run);
  ASSERT_TRUE(large.whole());
  EXPECT_LT(large.starved, 0.05);
  sim::GrblOptions old;
  old.rx_buffer = 127;
  old.planner = 15;
  const LineOutcome small = run_grbl(short_blocks(2000, 0.005), run, old);
  ASSERT_TRUE(small.whole());
  EXPECT_GT(small.starved, 1.0) << "a small window cannot hide the latency";
}

TEST(FieldFailures, F03_LostOk) {
  LineRun run;
  run.faults = "lose-ok p=0.01";
  const LineOutcome grbl = run_grbl(short_blocks(300, 0.004), run);
  ASSERT_GT(grbl.faults, 0u);
  expect_honest_fault(grbl);  // never guessed
  const LineOutcome numbered = run_reprap(short_blocks(300, 0.004), run);
  EXPECT_TRUE(numbered.whole()) << numbered.report.error().message;  // the numbers tell
  EXPECT_GT(numbered.faults, 0u);
}

TEST(FieldFailures, F04_GarbledOk) {
  for (int seed = 1; seed <= 40; ++seed) {
    LineRun run;
    run.faults = "seed " + std::to_string(seed) + "\ncorrupt to-host p=0.001\ninsert to-host p=0.001";
    const LineOutcome outcome = run_grbl(short_blocks(200, 0.004), run);
    if (outcome.report) {
      EXPECT_TRUE(outcome.whole()) << seed;
    } else {
      expect_honest_fault(outcome);
    }
  }
}

TEST(FieldFailures, F05_UsbDropsInMidJob) {
  LineRun run;
  run.faults = "disconnect at=1.5 for=2";
  for (const LineOutcome& outcome :
       {run_grbl(short_blocks(600, 0.005), run), run_reprap(short_blocks(600, 0.005), run)}) {
    expect_honest_fault(outcome);
    EXPECT_EQ(outcome.last.loss, Loss::kWire);
  }
}

TEST(FieldFailures, F06_ControllerResetsItself) {
  LineRun run;
  run.faults = "reset at=1.5";
  const LineOutcome grbl = run_grbl(short_blocks(600, 0.005), run);
  expect_honest_fault(grbl);
  EXPECT_LT(grbl.executed.size(), 400u) << "went on after the reset";
  const LineOutcome reprap = run_reprap(short_blocks(600, 0.005), run);
  expect_honest_fault(reprap);
  EXPECT_EQ(reprap.last.loss, Loss::kRestarted);
  EXPECT_EQ(grbl.last.loss, Loss::kForgotten) << grbl.report.error().message;  // ALARM:3 comes first
}

TEST(FieldFailures, F07_ResendWithoutOk) {
  sim::RepRapOptions firmware;
  firmware.resend_ok = false;
  for (const int window : {1, 4}) {
    LineRun run;
    run.profile.reprap_window = window;
    run.faults = "corrupt to-machine p=0.0005";
    const LineOutcome outcome = run_reprap(short_blocks(300, 0.004), run, firmware);
    EXPECT_TRUE(outcome.whole()) << outcome.report.error().message;
    EXPECT_GT(outcome.last.resends, 0u);
  }
}

TEST(FieldFailures, F08_WrongLineResent) {
  for (const bool advanced : {false, true})
    for (int seed = 1; seed <= 10; ++seed) {
      sim::RepRapOptions firmware;
      firmware.advanced_ok = advanced;
      LineRun run;
      run.profile.reprap_window = 4;
      run.faults =
          "seed " + std::to_string(seed) + "\ndrop to-machine p=0.0005\nduplicate to-machine p=0.0005";
      const LineOutcome outcome = run_reprap(short_blocks(300, 0.004), run, firmware);
      EXPECT_TRUE(outcome.whole()) << "seed " << seed << ": " << outcome.report.error().message;
    }
}

TEST(FieldFailures, F09_EndlessResend) {
  RepRapSession session({3, 1}, Time{0});
  Time now{0};
  std::string in;
  for (int i = 0; i < 200 && !is_final(session.phase()); ++i, now += milliseconds(10)) {
    if (session.wants_work()) session.push({1, "G1X1"});
    const std::string out(session.output(now));
    session.sent(out.size());
    if (out.find("M110") != out.npos) in = "ok\n";
    if (out.find("M115") != out.npos) in = "FIRMWARE_NAME:Marlin\nok\n";
    if (out.find("G1X1") != out.npos) in = "Error:checksum mismatch, Last Line: 1\nResend: 2\nok\n";
    session.receive(in, now);
    in.clear();
  }
  ASSERT_EQ(session.phase(), Phase::kFault);
  EXPECT_NE(session.error().message.find("again and again"), std::string::npos) << session.error().message;
}

TEST(FieldFailures, F10_TheNumberOfAResendIsDamaged) {
  LineRun run;
  run.profile.reprap_window = 4;
  run.faults = "corrupt to-machine p=0.0005\nwrong-line p=1";
  const LineOutcome outcome = run_reprap(short_blocks(300, 0.004), run);
  EXPECT_TRUE(outcome.whole()) << outcome.report.error().message;
  EXPECT_GT(outcome.faults, 5u);
}

TEST(FieldFailures, F11_UnnumberedLineInANumberedStream) {
  LineRun run;
  run.watch = [](const SendState& state, double, CommandQueue& queue) {
    if (state.phase == Phase::kRun) queue.push({Order::kFeedOverride, 90});
  };
  const LineOutcome outcome = run_reprap(short_blocks(200, 0.02), run);
  ASSERT_TRUE(outcome.whole()) << outcome.report.error().message;
  std::istringstream lines(outcome.said);
  int overrides = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    EXPECT_EQ(line[0], 'N') << line;
    EXPECT_NE(line.find('*'), line.npos) << line;
    overrides += line.find("M220S90") != line.npos;
  }
  EXPECT_GT(overrides, 0);
}

TEST(FieldFailures, F12_LongCommentAndLongLine) {
  std::string program =
      "G21 G90 G94 (" + std::string(5000, 'x') + ")\nG0 X0 Y0 Z0 A0 C0 ; " + std::string(300, 'y') + "\nM2\n";
  const LineOutcome fine = run_grbl(program, {});
  EXPECT_TRUE(fine.whole()) << fine.report.error().message;
  sim::GrblOptions old;
  old.rx_buffer = 127;
  old.max_line = 79;
  LineRun run;
  const LineOutcome refused = run_grbl(
      "G21G90\nG0X0Y0Z0A0C0N0000000000000000000000000000000000000000000000000000000000000000000000000\nM2\n",
      run, old);
  if (refused.report) {
    EXPECT_TRUE(refused.whole());
  } else {
    EXPECT_TRUE(refused.executed.empty());
  }
}

TEST(FieldFailures, F13_LiveBytesInComments) {
  const LineOutcome outcome =
      run_grbl("G21 G90 G94 (hold! go~ what?)\nG0 X0 Y0 Z0 A0 C0 ; ! ~ ?\nG93\nG1 X1 F60\nM2\n", {});
  EXPECT_TRUE(outcome.whole()) << outcome.report.error().message;
  EXPECT_FALSE(says_after(outcome, 0, '!'));
  EXPECT_FALSE(says_after(outcome, 0, '~'));
}

TEST(FieldFailures, F14_BytesFrom0x80) {
  const LineOutcome comment =
      run_grbl("G21 G90 G94 (gr\xC3\xBC\xC3\x9F, \x85 \x9E)\nG0 X0 Y0 Z0 A0 C0\nM2\n", {});
  ASSERT_TRUE(comment.whole()) << comment.report.error().message;
  for (const char c : comment.said) EXPECT_GE(c, 0);
  const LineOutcome data = run_grbl("G21\nG0 X0 Y0 Z0 A0 C0\nG1 X\x85 1\nM2\n", {});
  ASSERT_FALSE(data.report);
  EXPECT_TRUE(data.said.find("G0") == data.said.npos) << "nothing may be sent";
}

TEST(FieldFailures, F15_EepromWritesLoseReceivedBytes) {
  GrblBench bench({"G1X1", "G10L2P1X0", "G1X2", "G1X3"});
  bench.open();
  for (int i = 0; i < 10; ++i) bench.exchange();
  EXPECT_EQ(bench.session.state().sent, 1u);
  bench.fake.work();
  for (int i = 0; i < 10; ++i) bench.exchange();
  EXPECT_EQ(bench.session.state().sent, 2u) << "the write must travel alone";
  bench.finish();
  EXPECT_EQ(bench.session.phase(), Phase::kDone);
}

TEST(FieldFailures, F16_DroppedBytesFuseTwoLines) {
  GrblBench bench(numbered(40));
  bench.open();
  bench.feed();
  bool dropped = false;
  for (int i = 0; i < 400 && !is_final(bench.session.phase()); ++i) {
    bench.feed();
    std::string out(bench.session.output(bench.now));
    bench.session.sent(out.size());
    if (const std::size_t at = out.find("\nG1X30"); at != out.npos && !dropped)
      out.erase(at, 1), dropped = true;
    bench.fake.receive(out);
    while (bench.fake.work()) {
    }
    bench.session.receive(bench.fake.replies, bench.now);
    bench.fake.replies.clear();
    bench.now += milliseconds(100);
  }
  ASSERT_TRUE(dropped);
  EXPECT_EQ(bench.session.phase(), Phase::kFault) << "one ok fewer than lines";
}

TEST(FieldFailures, F18_IdleIsNotDone) {
  const LineOutcome outcome =
      run_grbl("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG93\nG1 X1 F30\nG4 P3\nG1 X2 F30\nM2\n", {});
  ASSERT_TRUE(outcome.report);
  EXPECT_TRUE(outcome.whole()) << "done was said too early";
  EXPECT_GT(outcome.seconds, 7.0);
  EXPECT_TRUE(run_reprap("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG93\nG1 X1 F30\nG1 X2 F30\nM2\n", {}).whole());
}

TEST(FieldFailures, F20_TheControllerHoldsWhenTheSenderDies) {
  const CampaignProgram program(2000);
  std::vector<sim::Block> executed;
  RingWire wire(wide_machine(), {}, {}, SeededBug::kNone,
                [&](const sim::TraceRow& row) { executed.push_back(row.command); });
  wire.die_at = 60;
  ASSERT_FALSE(send_over(program.path, *parse_link("modbus-rtu:/dev/null@115200/1"), wire, wire, {5}, {}));
  wire.die_at = ~0ULL;
  std::string in;
  for (int i = 0; i < 30; ++i) static_cast<void>(wire.exchange({}, milliseconds(100), in));
  const bool held = wire.controller.state() == sim::RunState::kHold || wire.controller.motion().idle();
  EXPECT_TRUE(held);
}

TEST(FieldFailures, F21_AlarmWithLinesInFlight) {
  LineRun run;
  run.faults = "alarm at=1.5";
  const LineOutcome outcome = run_grbl(short_blocks(600, 0.005), run);
  expect_honest_fault(outcome);
  EXPECT_EQ(outcome.last.phase, Phase::kAlarm);
  EXPECT_NE(outcome.report.error().message.find("ALARM:1"), std::string::npos);
}

TEST(FieldFailures, F22_WithheldOkOfM0) {
  for (const bool reprap : {false, true}) {
    LineRun run;
    double waits_since = 0.0;
    bool waited = false;
    run.watch = [&](const SendState& state, double now, CommandQueue& queue) {
      if (state.phase != Phase::kToolChange) return;
      if (waits_since == 0.0) waits_since = now;
      if (now - waits_since > 600.0) waited = true, queue.push({Order::kResume});
    };
    const std::string program = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nM0\nG93\nG1 X1 F60\nM2\n";
    const LineOutcome outcome = reprap ? run_reprap(program, run) : run_grbl(program, run);
    EXPECT_TRUE(outcome.whole()) << outcome.report.error().message;
    EXPECT_TRUE(waited);
  }
}

TEST(FieldFailures, F23_LongCommands) {
  const std::string program = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG4 P200\nG93\nG1 X1 F0.3\nM2\n";
  EXPECT_TRUE(run_grbl(program, {}).whole());
  EXPECT_TRUE(run_reprap(program, {}).whole());
}

TEST(FieldFailures, F25_XoffObeyedTooLate) {
  sim::DripControlOptions control;
  control.buffer = 128;
  control.stop_free = 32;
  control.go_free = 96;
  std::vector<sim::Block> executed;
  sim::DripController machine(wide_machine(), {}, control,
                              [&](const sim::TraceRow& row) { executed.push_back(row.command); });
  VirtualLine<sim::DripController> line(machine, {}, 11.0 / 9600);
  const CampaignProgram program(300);
  std::ofstream(program.path) << short_blocks(300, 0.1);  // slower than the wire
  ASSERT_TRUE(send_over(program.path, *parse_link("dnc:/dev/null@9600"), line, line, {}, {}));
  EXPECT_EQ(machine.alarm(), 0);
  EXPECT_GT(machine.most_after_stop(), 0u) << "the control never had to stop the host";
  EXPECT_LE(machine.most_after_stop(), 11u) << "10 ms at 9600 baud and the byte on the wire";
}

TEST(FieldFailures, F26_ArcsUseSeveralPlannerSlots) {
  // The planner says that it is full for ever; only bytes decide what may be sent.
  GrblBench bench(numbered(30));
  bench.open();
  bench.say("<Run|MPos:0,0,0|Bf:0,128>\r\n");
  const std::uint64_t before = bench.session.state().sent;
  for (int i = 0; i < 5; ++i) bench.fake.work(), bench.exchange();
  EXPECT_GT(bench.session.state().sent, before);
}

}  // namespace
}  // namespace tiltfeed
