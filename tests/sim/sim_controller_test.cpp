// The Grbl firmware model under a scripted clock.

#include "sim/controller/grbl_controller.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/peers/sim_machine.h"

namespace tiltfeed::sim {
using namespace config;
namespace {

const std::string kBanner = "\r\nGrbl 1.1h ['$' for help]\r\n";

class Grbl : public ::testing::Test {
 protected:
  explicit Grbl(GrblOptions options = {})
      : controller(test_machine(), {}, options, [this](const TraceRow& row) { rows.push_back(row); }) {
    EXPECT_EQ(controller.take_output(), kBanner);
  }
  std::string say(std::string_view bytes) {
    controller.receive(bytes);
    return controller.take_output();
  }
  std::string run(double until) {
    controller.advance(until);
    return controller.take_output();
  }
  std::string status() { return say("?"); }
  static int count(const std::string& text, const std::string& what) {
    int found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
    return found;
  }
  /// n one-second lines.
  static std::string seconds(int n, int from = 1) {
    std::string text;
    for (int i = 0; i < n; ++i) text += "G93 G1 X" + std::to_string((from + i) % 100) + " F60\n";
    return text;
  }

  std::vector<TraceRow> rows;
  GrblController controller;
};

class SmallGrbl : public Grbl {
 protected:
  SmallGrbl() : Grbl({.rx_buffer = 40, .planner = 3}) {}
};

class OldGrbl : public Grbl {
 protected:
  OldGrbl()
      : Grbl({.rx_buffer = 127,
              .planner = 15,
              .max_line = 79,
              .latch_errors = false,
              .crlf_is_one_end = false}) {}
};

TEST_F(Grbl, ExecutesInSimulatedTimeAndWritesTheTrace) {
  EXPECT_EQ(say("N5 G93 G1 X6 Y8 A10 F30\nG0 X0 C90\nG94 G1 Z-100 F6000\n"), "ok\r\nok\r\nok\r\n");
  EXPECT_TRUE(rows.empty());
  run(1.999);
  EXPECT_TRUE(rows.empty());
  run(10);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].command.line, 5U);
  EXPECT_EQ(rows[0].command.target, (Joints{6, 8, 0, 10, 0}));
  EXPECT_DOUBLE_EQ(rows[0].end, 2.0) << "60 / F";
  EXPECT_DOUBLE_EQ(rows[1].end - rows[1].start, 0.15) << "C, 90 degrees at 36000 degrees/min";
  EXPECT_DOUBLE_EQ(rows[2].end - rows[2].start, 1.0) << "100 mm at 6000 mm/min";
  EXPECT_DOUBLE_EQ(controller.motion().totals().busy, rows[2].end);
  // With no tool and the tip 150 mm below the pivot: A tilts it by 10 degrees, Y carries it back.
  const double lever = 150 * std::sin(10 * kPi / 180);
  EXPECT_NEAR(rows[0].pose.tip.y, 8 + lever, 1e-9);
}

TEST_F(Grbl, NeverFasterThanItsAxes) {
  say("G93 G1 C180 F6000\n");  // 0.01 s asked, 0.3 s needed
  run(1);
  EXPECT_DOUBLE_EQ(rows.at(0).end, 0.3);
}

TEST_F(SmallGrbl, WithholdsOkWhileThePlannerIsFull) {
  EXPECT_EQ(count(say(seconds(4)), "ok"), 3);
  EXPECT_EQ(count(run(0.999), "ok"), 0);
  EXPECT_EQ(count(run(1.0), "ok"), 1) << "a slot is free again";
  EXPECT_EQ(count(run(9), "ok"), 0);
  EXPECT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows.back().end, 4.0) << "the planner never ran dry";
}

TEST_F(SmallGrbl, DropsWhatOverrunsItsReceiveBuffer) {
  std::string text;  // lines of 14 bytes: 4 are placed or due, 40 bytes wait
  for (int i = 0; i < 5; ++i) text += "G93 G1 X1 F60\nG93 G1 X2 F60\n";
  EXPECT_EQ(count(say(text), "ok"), 3);
  EXPECT_EQ(controller.dropped_bytes(), 6 * 14 - 40U);
  const std::string rest = run(100);
  // 2 whole lines and 12 bytes of a third are left: it waits for its line end and is a line with the next.
  EXPECT_EQ(count(rest, "ok"), 3);
  EXPECT_EQ(rows.size(), 6U);
  EXPECT_EQ(say("\n"), "ok\r\n") << "'G93 G1 X1 F6' is a legal, wrong line";
  EXPECT_EQ(controller.motion().running()->feed, 6);
}

TEST_F(SmallGrbl, AHostThatCountsLosesNothing) {
  const int lines = 500;
  std::string text = seconds(lines), out;
  std::size_t sent = 0, acked_bytes = 0, read = 0;
  std::vector<std::size_t> lengths;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lengths.push_back(line.size() + 1);
  for (std::size_t next = 0; read < lengths.size();) {
    while (next < lengths.size() && sent + lengths[next] - acked_bytes <= 40) {
      out += say(text.substr(sent, lengths[next]));
      sent += lengths[next++];
    }
    for (const int oks = count(out, "ok"); static_cast<int>(read) < oks;) acked_bytes += lengths[read++];
    if (controller.next_event()) out += run(*controller.next_event());
  }
  run(1000);
  EXPECT_EQ(controller.dropped_bytes(), 0U);
  EXPECT_EQ(rows.size(), 500U);
  EXPECT_EQ(rows.back().end, 500.0);
  EXPECT_EQ(controller.motion().totals().starved, 0.0);
}

TEST_F(Grbl, BarrierAnswersWhenAllBeforeItIsExecuted) {
  EXPECT_EQ(count(say(seconds(2) + "G4 P0.5\nG0 X0\n"), "ok"), 2);
  EXPECT_EQ(run(2.2), "");
  EXPECT_NE(status().find("<Idle|"), std::string::npos) << "Idle shows during a dwell";
  EXPECT_EQ(count(run(2.5), "ok"), 2);
  EXPECT_EQ(rows.size(), 3U);
}

TEST_F(Grbl, ProgramEndAnswersWhenExecuted) {
  EXPECT_EQ(count(say(seconds(1) + "M2\n"), "ok"), 1);
  EXPECT_FALSE(controller.program_ended());
  EXPECT_EQ(run(1.0), "ok\r\n");
  EXPECT_TRUE(controller.program_ended());
  EXPECT_EQ(rows.back().command.m_code, 2);
}

TEST_F(Grbl, M0WaitsForTheOperator) {
  EXPECT_EQ(say("M0\nG0 X1\n"), "");
  EXPECT_NE(status().find("<Hold:0|"), std::string::npos);
  EXPECT_EQ(run(50), "");
  EXPECT_EQ(say("~"), "ok\r\nok\r\n");
}

TEST_F(Grbl, HoldAndResume) {
  say(seconds(2));
  run(0.25);
  EXPECT_EQ(say("!"), "") << "real-time bytes earn no reply";
  EXPECT_NE(status().find("<Hold:0|MPos:0.250,"), std::string::npos);
  run(100);
  EXPECT_TRUE(rows.empty());
  EXPECT_FALSE(controller.next_event());
  say("~");
  EXPECT_NE(status().find("<Run|"), std::string::npos);
  run(200);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_DOUBLE_EQ(rows[0].end, 100.75);
  EXPECT_DOUBLE_EQ(controller.motion().totals().busy, 2.0) << "the hold is not counted";
}

TEST_F(Grbl, RealTimeBytesAreTakenOutOfALine) {
  const std::string out =
      say("G9?3 G1 X1!0 F\x90"
          "60\n");
  EXPECT_EQ(count(out, "<Idle"), 1);
  EXPECT_EQ(count(out, "ok"), 1);
  say("~");
  run(2);
  EXPECT_EQ(rows.at(0).command.target.x, 10);
}

TEST_F(Grbl, FeedOverrideStretchesTheRunningBlock) {
  say(seconds(1));
  run(0.5);
  say("\x92\x92\x92\x92\x92");  // 50 %
  EXPECT_NE(status().find("|Ov:50,100,100>"), std::string::npos);
  run(9);
  EXPECT_DOUBLE_EQ(rows.at(0).end, 1.5);
}

TEST_F(Grbl, ReportsWhatTurnsAndFlowsUntilAReset) {
  EXPECT_EQ(status().find("|A:"), std::string::npos);
  say("M4 S900\nM7\nM8\n");
  EXPECT_NE(status().find(",900|Ov:100,100,100|A:CFM>"), std::string::npos);
  EXPECT_EQ(status().find("|A:"), std::string::npos) << "said once, as the firmware does";
  EXPECT_NE(say("$G\n").find(" M4 M7 M8 "), std::string::npos);
  say("M3 S700\nM9\n");
  EXPECT_NE(status().find(",700|Ov:100,100,100|A:S>"), std::string::npos);
  say("!\x18");
  EXPECT_NE(status().find(",0|WCO:0.000,0.000,-500.000,0.000,0.000|Ov:100,100,100>"), std::string::npos);
}

TEST_F(Grbl, ResetInMotionIsAnAlarm) {
  say(seconds(5));
  run(1.5);
  EXPECT_EQ(say("\x18"), "ALARM:3\r\n" + kBanner + "[MSG:'$H'|'$X' to unlock]\r\n");
  EXPECT_NE(status().find("<Alarm|MPos:1.500,"), std::string::npos);
  EXPECT_EQ(say("G0 X1\n"), "error:9\r\n");
  run(50);
  EXPECT_EQ(rows.size(), 1U) << "what was queued is gone";
  EXPECT_EQ(say("$X\n"), "[MSG:Caution: Unlocked]\r\nok\r\n");
  EXPECT_EQ(say("G93 G1 Y1 F60\n"), "ok\r\n");
  run(99);
  EXPECT_EQ(rows.at(1).command.target.x, 1.5) << "X stays where the reset stopped it";
}

TEST_F(Grbl, ResetAtRestOrInHoldIsNone) {
  EXPECT_EQ(say("\x18"), kBanner);
  say(seconds(2) + "!");
  EXPECT_EQ(say("\x18"), kBanner);
  EXPECT_EQ(say("G0 X1\n"), "ok\r\n");
}

TEST_F(Grbl, AnErrorIsLatchedUntilAnEmptyOrSystemLine) {
  EXPECT_EQ(say("G0 Q1\nG0 X1\nG1 X2\n"), "error:20\r\nerror:20\r\nerror:20\r\n");
  EXPECT_EQ(say("\nG0 X1\n"), "ok\r\nok\r\n");
  EXPECT_EQ(say("G0 X1.1.1\nG0 X1\n"), "error:2\r\nerror:2\r\n");
  EXPECT_EQ(say("$G\n"), "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]\r\nok\r\n");
  EXPECT_EQ(say("G0 X2\n"), "ok\r\n");
  run(10);
  EXPECT_EQ(count(say("G0 Q1\n\x18"), "Grbl"), 1);
  EXPECT_EQ(say("G0 X3\n"), "ok\r\n");
}

TEST_F(OldGrbl, GoesOnAfterAnErrorAndCountsBothLineEnds) {
  EXPECT_EQ(say("G0 Q1\nG0 X1\n"), "error:20\r\nok\r\n");
  EXPECT_EQ(say("G0 X1\r\n"), "ok\r\nok\r\n");
  EXPECT_EQ(say("G0 X1" + std::string(74, ' ') + "\n"), "ok\r\n");
  EXPECT_EQ(say("G0 X1" + std::string(75, ' ') + "\n"), "error:11\r\n");
}

TEST_F(Grbl, LineEndsAndLongLines) {
  EXPECT_EQ(say("G0 X1\r\nG0 X2\r\n"), "ok\r\nok\r\n");
  EXPECT_EQ(say("G0 X1\rG0 X2\n"), "ok\r\nok\r\n");
  EXPECT_EQ(say("\n\n"), "ok\r\nok\r\n");
  EXPECT_EQ(say("G0 X1" + std::string(251, ' ') + "\n"), "ok\r\n");
  EXPECT_EQ(say("G0 X1" + std::string(252, ' ') + "\nG0\n"), "error:11\r\nerror:11\r\n");
}

TEST_F(Grbl, SoftLimitIsAnAlarmWithoutReply) {
  say(seconds(2));
  EXPECT_EQ(say("G0 Z-500.0001\n"), "ALARM:2\r\n[MSG:Reset to continue]\r\n");
  EXPECT_EQ(say("G0 X1\n$X\n"), "error:9\r\nerror:9\r\n");
  run(50);
  EXPECT_TRUE(rows.empty());
  EXPECT_EQ(count(say("\x18"), "ALARM"), 0);
  EXPECT_EQ(say("G0 X1\n"), "error:9\r\n");
  say("$X\n");
  EXPECT_EQ(say("G0 Z-500 A110 C-36000\n"), "ok\r\n") << "the limits themselves are inside";
}

TEST_F(Grbl, CheckModeMovesNothing) {
  EXPECT_EQ(say("$C\n"), "[MSG:Enabled]\r\nok\r\n");
  EXPECT_NE(status().find("<Check|"), std::string::npos);
  EXPECT_EQ(say("G0 X1\nM2\nG0 Q1\n"), "ok\r\nok\r\nerror:20\r\n");
  EXPECT_EQ(say("$C\n"), "[MSG:Disabled]\r\nok\r\n" + kBanner);
  run(50);
  EXPECT_TRUE(rows.empty());
}

TEST_F(SmallGrbl, ReportsItsBuffers) {
  EXPECT_NE(say("$I\n").find("[OPT:VN,3,40]\r\n"), std::string::npos);
  EXPECT_NE(status().find("|Bf:3,40|"), std::string::npos);
  say("N77 G93 G1 X1 F60\nG1 X2 F60\nG1 X3 F60\nG1 X4 F60\nG1 X5");
  const std::string report = status();
  EXPECT_NE(report.find("|Bf:0,35|"), std::string::npos) << report;
  EXPECT_NE(report.find("|Ln:77|FS:60,0"), std::string::npos) << report;
}

TEST_F(Grbl, CountsStarvedTimeInsideAProgramOnly) {
  run(10);
  say(seconds(1));
  run(13);  // executed at 11, starved for 2 s
  say(seconds(1, 2));
  run(14);
  say("!");
  run(20);  // a hold is no starvation
  say("~");
  say("M2\n");
  run(90);
  say(seconds(1));
  run(100);
  EXPECT_DOUBLE_EQ(controller.motion().totals().starved, 2.0);
  EXPECT_EQ(controller.motion().totals().programs, 1U);
}

TEST_F(Grbl, SameBytesSameTrace) {
  std::string text;
  for (int i = 0; i < 300; ++i)
    text += "G93 G1 X" + std::to_string(i % 37) + " C" + std::to_string(i) + " F600\n";
  std::string first;
  for (const std::size_t piece : {std::size_t{1}, std::size_t{13}, text.size()}) {
    std::vector<TraceRow> got;
    GrblController other(test_machine(), {}, {.rx_buffer = 100000},
                         [&](const TraceRow& row) { got.push_back(row); });
    for (std::size_t at = 0; at < text.size(); at += piece) other.receive(text.substr(at, piece));
    other.advance(1000);
    ASSERT_EQ(got.size(), 300U);
    std::ostringstream csv;
    for (const TraceRow& row : got) write_trace_row(row, csv);
    if (first.empty()) first = csv.str();
    EXPECT_EQ(csv.str(), first) << piece;
  }
}

}  // namespace
}  // namespace tiltfeed::sim
