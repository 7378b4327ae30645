// What a controller reports of its axes against the program: check mode, a machine that does not move, a line
// that was changed on its way.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "daemon/protocol/position_watch.h"
#include "tests/peers/fake_grbl.h"
#include "tests/peers/line_run.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

TEST(CheckMode, IsRefusedAtTheOpening) {
  for (const char* state : {"Check", "Hold:0", "Door:0", "Sleep", "Jog"}) {
    GrblBench bench(numbered(20));
    bench.fake.state = state;
    for (int i = 0; i < 12 && !is_final(bench.session.phase()); ++i) bench.exchange(seconds(1));
    EXPECT_EQ(bench.session.phase(), Phase::kFault) << state;
    EXPECT_NE(bench.session.error().message.find(state), std::string::npos) << bench.session.error().message;
    EXPECT_TRUE(bench.fake.lines.empty()) << state;
  }
}

TEST(CheckMode, IsAFaultWhileItRuns) {
  GrblBench bench(numbered(200));
  bench.open();
  bench.fake.state = "Check";
  for (int i = 0; i < 300 && !is_final(bench.session.phase()); ++i) {
    bench.fake.work();
    bench.exchange();
  }
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_NE(bench.session.error().message.find("check mode"), std::string::npos);
}

TEST(CheckMode, AFailedCheckLeavesItAgain) {
  GrblOptions options;
  options.check = true;
  GrblBench bench(numbered(20), FakeGrbl(), options);
  for (int i = 0; i < 20 && bench.session.phase() != Phase::kCheck; ++i) bench.exchange();
  ASSERT_EQ(bench.session.phase(), Phase::kCheck);
  bench.exchange();
  bench.fake.work();  // $C
  bench.exchange();
  bench.exchange();  // a report shows it
  bench.talk();
  bench.fake.work("error:20");
  bench.listen();
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  bench.fake.receive(bench.session.output(bench.now));
  EXPECT_EQ(bench.fake.resets, 1) << "only a reset ends check mode";
  // The simulated firmware, which keeps to check mode after an error as the real one does.
  LineRun run;
  run.options.check = true;
  const LineOutcome outcome = run_grbl("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 X1 F100\nG999\nM2\n", run);
  ASSERT_FALSE(outcome.report);
  EXPECT_NE(outcome.report.error().message.find("nothing has moved"), std::string::npos);
  EXPECT_TRUE(outcome.executed.empty());
  EXPECT_EQ(outcome.said.back(), '\x18');
}

/// Some firmware answers ok to $C and has no check mode: the program would be cut as it is read.
TEST(CheckMode, A2NoLineLeavesBeforeAReportShowsIt) {
  GrblOptions options;
  options.check = true;
  GrblBench bench(numbered(20), FakeGrbl(), options);
  bench.fake.checks = false;
  bench.finish(2000);
  EXPECT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_NE(bench.session.error().message.find("state Idle, not in check mode"), std::string::npos)
      << bench.session.error().message;
  EXPECT_EQ(bench.fake.lines, std::vector<std::string>{"$C"});
  EXPECT_EQ(bench.fake.executed_x, 0);
}

TEST(CheckMode, A2WhatLeavesItUnaskedMayHaveMoved) {
  GrblOptions options;
  options.check = true;
  GrblBench bench(numbered(200), FakeGrbl(), options);
  for (int i = 0; i < 100 && bench.fake.lines.size() < 5; ++i) {
    bench.fake.work();
    bench.exchange();
  }
  ASSERT_EQ(bench.session.phase(), Phase::kCheck);
  bench.fake.state = "Run";
  for (int i = 0; i < 1000 && !is_final(bench.session.phase()); ++i) {
    bench.fake.work();
    bench.exchange();
  }
  const std::string why = bench.session.error().message;
  EXPECT_NE(why.find("left check mode"), std::string::npos) << why;
  EXPECT_NE(why.find("blocks 1 to "), std::string::npos) << why;
  EXPECT_EQ(why.find("nothing has moved"), std::string::npos) << why;
  EXPECT_GE(bench.session.state().uncertain.last, bench.fake.lines.size() - 1);
  bench.fake.receive(bench.session.output(bench.now));
  EXPECT_EQ(bench.fake.holds, 1);
}

/// Stopped in the middle of lines that are all answered, with one figure of the first report changed.
TEST(PlausiblePosition, A4OneChangedFigureDoesNotNarrowTheRange) {
  for (const char* changed : {"15.000", "5.000", "25.000"}) {
    GrblBench bench(numbered(20));
    bench.open();
    for (int i = 0; i < 200 && bench.fake.lines.size() < 20; ++i) bench.fake.work(), bench.exchange();
    bench.fake.silent_status = true;
    bench.session.command({Order::kStop}, bench.now);
    for (const char* x : {changed, "5.000", "5.000", "5.000"}) {
      bench.exchange(milliseconds(250));
      if (bench.fake.resets > 0) break;
      bench.say(std::string("<Hold:0|MPos:") + x + ",0.000,0.000|Bf:15,128|WCO:0.000,0.000,0.000>\r\n");
    }
    bench.exchange();
    ASSERT_EQ(bench.session.phase(), Phase::kStopped) << bench.session.error().message;
    EXPECT_EQ(bench.session.state().uncertain.first, 5u) << changed;
    EXPECT_EQ(bench.session.state().uncertain.last, 6u) << changed;
    // All 20 were answered; those behind block 6 have gone with the reset.
    EXPECT_EQ(bench.session.state().executed, 4u);
    EXPECT_EQ(bench.session.state().acknowledged, 6u);
    EXPECT_EQ(bench.session.state().sent, 6u);
  }
}

TEST(PlausiblePosition, A4OneChangedLineNumberProvesNothing) {
  GrblOptions options;
  options.number_lines = true;
  GrblBench bench(numbered(20), FakeGrbl(1024), options);
  bench.say("GrblHAL 1.1f ['$' or '$HELP' for help]\r\n");
  bench.open();
  for (int i = 0; i < 200 && bench.fake.lines.size() < 20; ++i) bench.fake.work(), bench.exchange();
  bench.fake.silent_status = true;
  const auto report = [&](int line) {
    bench.say("<Hold:0|MPos:4.500,0.000,0.000|Ln:" + std::to_string(line) + "|Bf:15,128>\r\n");
    return bench.session.state().executed;
  };
  EXPECT_EQ(report(5), 0u) << "the first is believed when the next agrees";
  EXPECT_EQ(report(5), 4u);
  EXPECT_EQ(report(15), 4u) << "5 with a digit that the wire has made";
  EXPECT_EQ(report(5), 4u);
  EXPECT_EQ(report(6), 4u);
  EXPECT_EQ(report(7), 5u);
}

TEST(CheckMode, AControllerThatAnswersAndMovesNothingIsNotDone) {
  for (const int lines : {3, 400}) {
    GrblBench bench(numbered(lines));
    bench.fake.frozen = true;
    bench.finish();
    ASSERT_EQ(bench.session.phase(), Phase::kFault) << lines;
    EXPECT_NE(bench.session.error().message.find("X0 Y0 Z0"), std::string::npos)
        << bench.session.error().message;
  }
}

TEST(CheckMode, TheEndIsProvedByTheReportedPosition) {
  GrblBench bench(numbered(3));
  bench.fake.position = 1;  // one mm off, from the start to the end
  bench.finish();
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  // In coordinates that nobody tells nothing can be compared: then the barrier is all there is.
  GrblBench unknown(numbered(3));
  unknown.fake.position = 1;
  unknown.fake.offsets = false;
  unknown.finish();
  EXPECT_EQ(unknown.session.phase(), Phase::kDone) << unknown.session.error().message;
}

/// Changes the first bytes that fit, on their way to the machine.
class ChangedLink : public Link {
 public:
  ChangedLink(Link& wire, std::string from, std::string to)
      : wire_(wire), from_(std::move(from)), to_(std::move(to)) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    waiting_ += out;
    if (const std::size_t at = waiting_.find(from_); !done_ && at != waiting_.npos) {
      waiting_.replace(at, from_.size(), to_);
      done_ = true;
    }
    const Result<std::size_t> taken = wire_.exchange(waiting_, wait, in);
    if (!taken) return taken;
    waiting_.erase(0, *taken);
    return out.size();
  }

 private:
  Link& wire_;
  std::string from_, to_, waiting_;
  bool done_ = false;
};

TEST(PlausiblePosition, ALostDecimalPointIsFoundWhileTheMachineMoves) {
  struct Case {
    const char *from, *to;
  };
  for (const Case& c : {Case{"Y10.28", "Y1028"}, Case{"X5.140", "X5140"}, Case{"A-1.028", "A-10.28"},
                        Case{"Z44.86", "Z4.486"}}) {
    std::string program = "G21G90G94\nG0X0Y0Z50A0C0\nM3S8000\nG1F1200\n";
    for (int i = 1; i <= 900; ++i) {
      char line[100];
      std::snprintf(line, sizeof line, "G1X%.3fY%.3fZ%.3fA%.3fC%.3f\n", i * 0.01, i * 0.02, 50 - i * 0.01,
                    -i * 0.002, i * 0.05);
      program += line;
    }
    program += "M2\n";
    ASSERT_NE(program.find(c.from), std::string::npos) << c.from;
    const Folder folder("place");
    const std::string path = folder.write("part.nc", program);
    MachineModel machine = wide_machine();
    machine.x.max = machine.y.max = 20000;
    machine.x.velocity = machine.y.velocity = machine.z.velocity = 6000;
    sim::GrblController controller(machine, {}, {}, [](const sim::TraceRow&) {});
    VirtualLine<sim::GrblController> line(controller, {}, 10.0 / 115200);
    ChangedLink changed(line, c.from, c.to);
    const LinkSpec spec = *parse_link("grbl:/dev/null@115200");
    const auto report = send_over(path, spec, changed, line, {}, {});
    ASSERT_FALSE(report) << c.from;
    EXPECT_NE(report.error().message.find("the machine is at X"), std::string::npos)
        << report.error().message;
    // Held soon after it left the way: two reports and the braking.
    const Joints at = controller.motion().position();
    EXPECT_LT(at.y, 10.28 + 40.0) << c.from;
    EXPECT_LT(at.x, 5.14 + 40.0) << c.from;
    EXPECT_TRUE(controller.motion().idle()) << "nothing is left that could run on";
    EXPECT_EQ(controller.motion().accessories().spindle, 0.0);
    EXPECT_EQ(controller.alarm(), 0);
  }
}

/// Two damages that the XOR of a RepRap line does not see: the place at the end tells them.
TEST(PlausiblePosition, ARepRapLineThatWasChangedInTwoBytesIsFoundAtTheEnd) {
  const Folder folder("place");
  const std::string path =
      folder.write("part.nc", "G21\nG90\nG94\nM3 S8000\nM8\nG1 X1 Y2 Z30 A0 C0 F1200\nG1 X22 Y44\n");
  for (const bool change : {false, true}) {
    sim::RepRapController controller(wide_machine(), {}, {}, [](const sim::TraceRow&) {});
    VirtualLine<sim::RepRapController> line(controller, {}, 10.0 / 115200);
    ChangedLink changed(line, "X22Y44", change ? "X32Y54" : "X22Y44");
    const auto report = send_over(path, *parse_link("reprap:/dev/null@115200"), changed, line, {}, {});
    ASSERT_EQ(report.has_value(), !change) << (report ? "" : report.error().message);
    if (!change) continue;
    EXPECT_NE(report.error().message.find("X32 Y54"), std::string::npos) << report.error().message;
    EXPECT_NE(report.error().message.find("turned off"), std::string::npos) << report.error().message;
    EXPECT_EQ(controller.motion().accessories().spindle, 0.0) << "B8: a fault leaves no spindle on";
    EXPECT_FALSE(controller.motion().accessories().flood);
  }
}

TEST(PlausiblePosition, BeyondTheTravelsIsAFault) {
  MachineModel machine = wide_machine();
  machine.y.max = 10.0;
  GrblOptions options;
  options.positions = position_limits({}, &machine);
  GrblBench bench({"G28", "G1X1", "G1X2"}, FakeGrbl(), options);  // after G28 no line says where the axes are
  bench.open();
  EXPECT_EQ(bench.session.phase(), Phase::kDrain);
  bench.say("<Run|MPos:0.000,10.050,0.000|WCO:0.000,0.000,0.000>\r\n");
  bench.say("<Run|MPos:0.000,10.200,0.000>\r\n");
  EXPECT_EQ(bench.session.phase(), Phase::kDrain) << "one damaged report is no fault";
  bench.say("<Run|MPos:0.000,10.200,0.000>\r\n");
  ASSERT_EQ(bench.session.phase(), Phase::kFault);
  EXPECT_NE(bench.session.error().message.find("travel"), std::string::npos) << bench.session.error().message;
}

/// Three lines of four take no block of the planner, so that the window in lines is longer than the planner.
TEST(PlausiblePosition, LinesWithoutMotionDoNotHideTheBlockInExecution) {
  const Folder folder("place");
  std::string program = "G21G90G94\nG0X0Y0Z50A0C0\nG1F1200\n";
  for (int i = 1; i <= 400; ++i)
    program += "G1X" + std::to_string(i % 2 * 3) + "Y" + std::to_string(i) + "\nF1200\nG1\nF1100\n";
  const std::string path = folder.write("part.nc", program + "M2\n");
  std::size_t rows = 0;
  sim::GrblController controller(wide_machine(), {}, {}, [&](const sim::TraceRow&) { ++rows; });
  VirtualLine<sim::GrblController> line(controller, {}, 10.0 / 115200);
  StreamHooks hooks;
  hooks.progress = [&](const SendState& state) {
    // Line 4 k is that of move k; three lines before the first.
    EXPECT_LE(state.executed, 3 + 4 * rows) << "more is told as executed than was";
    return true;
  };
  const auto report = send_over(path, *parse_link("grbl:/dev/null@115200"), line, line, {}, hooks);
  EXPECT_TRUE(report) << report.error().message;
}

/// A retract in machine coordinates hides the place of its own axis only.
TEST(PlausiblePosition, AfterG53TheOtherAxesAreStillKnown) {
  PositionWatch watch({});
  AxisValues at = no_axes();
  at[0] = at[1] = at[2] = 0.0;
  watch.begin(at);
  watch.push(1, "G0X10Y20Z30");
  watch.push(2, "G53G0Z0");
  watch.push(3, "M2");
  ASSERT_TRUE(watch.knows_end());
  at[0] = 10, at[1] = 20, at[2] = -77;
  EXPECT_TRUE(watch.at_end(at, 0.0005));
  watch.executed(1);
  EXPECT_EQ(watch.judge(at, 0.0005), "");
  at[1] = 21;
  EXPECT_FALSE(watch.at_end(at, 0.0005));
  EXPECT_NE(watch.judge(at, 0.0005), "");
}

TEST(PlausiblePosition, AnOffsetThatChangesIsNoFault) {
  GrblBench bench(numbered(400));
  bench.open();
  for (int i = 0; i < 20; ++i) bench.fake.work(), bench.exchange();
  bench.say("<Run|MPos:520.000,0.000,0.000|WCO:500.000,0.000,0.000>\r\n");
  bench.say("<Run|MPos:520.000,0.000,0.000>\r\n");
  bench.say("<Run|MPos:521.000,0.000,0.000>\r\n");
  EXPECT_EQ(bench.session.phase(), Phase::kRun) << bench.session.error().message;
}

// Against dense sampling of random ways: on the way is right, off it by more than the tolerance wrong.
TEST(PlausiblePosition, AgreesWithDenseSampling) {
  std::mt19937 random(11);
  const auto pick = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  for (int round = 0; round < 200; ++round) {
    PositionWatch watch({});
    AxisValues start = no_axes();
    start[0] = start[1] = start[2] = start[3] = start[5] = 0.0;
    watch.begin(start);
    std::vector<AxisValues> corners{start};
    for (std::uint64_t n = 1; n <= 12; ++n) {
      AxisValues next = corners.back();
      std::string line = "G1";
      for (const std::size_t axis : {0, 1, 2, 3, 5}) {
        if (pick(0, 1) < 0.4) continue;
        next[axis] = std::round(pick(-3, 3) * 1000.0) / 1000.0;
        line += kAxisLetters[axis] + std::to_string(next[axis]);
      }
      watch.push(n, line + "F100");
      corners.push_back(next);
    }
    const auto gone = static_cast<std::size_t>(pick(0, 8));
    watch.executed(gone);
    for (int probe = 0; probe < 40; ++probe) {
      const auto leg = static_cast<std::size_t>(pick(static_cast<double>(gone), 11.999));
      const double share = pick(0, 1);
      AxisValues at = no_axes();
      for (const std::size_t axis : {0, 1, 2, 3, 5})
        at[axis] =
            corners[leg][axis] + share * (corners[leg + 1][axis] - corners[leg][axis]) + pick(-0.09, 0.09);
      EXPECT_EQ(watch.judge(at, 0.0), "") << "round " << round;
      for (const std::size_t axis : {0, 1, 2, 3, 5}) at[axis] = pick(-3, 3);
      double least = 1e9;  // the largest deviation of any axis, at the best place
      for (std::size_t k = gone; k < 12; ++k)
        for (int s = 0; s <= 500; ++s) {
          double most = 0.0;
          for (const std::size_t axis : {0, 1, 2, 3, 5})
            most = std::max(most, std::abs(corners[k][axis] +
                                           s / 500.0 * (corners[k + 1][axis] - corners[k][axis]) - at[axis]));
          least = std::min(least, most);
        }
      if (least > 0.1 + 1e-9 && least < 0.11) continue;  // between two samples
      EXPECT_EQ(watch.judge(at, 0.0).empty(), least <= 0.1) << "round " << round << ", " << least;
    }
  }
}

}  // namespace
}  // namespace tiltfeed
