// The Grbl firmware model and its operator: jogs, homing, probing, work offsets, settings, as grblHAL
// answers.

#include <gtest/gtest.h>

#include "sim/controller/grbl_controller.h"
#include "tests/peers/sim_machine.h"

namespace tiltfeed::sim {
using namespace config;
namespace {

class GrblOperator : public ::testing::Test {
 protected:
  explicit GrblOperator(GrblOptions options = {})
      : controller(test_machine(), {}, options, [this](const TraceRow& row) { rows.push_back(row); }) {
    controller.take_output();
  }
  std::string say(std::string_view bytes) {
    controller.receive(bytes);
    return controller.take_output();
  }
  std::string run(double seconds) {
    controller.advance(controller.now() + seconds);
    return controller.take_output();
  }
  std::vector<TraceRow> rows;
  GrblController controller;
};

TEST_F(GrblOperator, JogsBesideTheModalState) {
  EXPECT_EQ(say("G90 G93\n"), "ok\r\n");
  EXPECT_EQ(say("$J=G91 G21 X10 F600\n$J=G91X-4Y3F600\n"), "ok\r\nok\r\n");
  EXPECT_EQ(say("?").find("<Jog|"), 0u);
  EXPECT_EQ(say("G0 X1\n"), "error:9\r\n") << "locked by the jog";
  run(3.0);
  EXPECT_EQ(say("?").find("<Idle|"), 0u);
  EXPECT_EQ(controller.motion().position(), (Joints{6, 3, 0, 0, 0}));
  EXPECT_NEAR(rows.at(1).end, 1.0 + 0.5, 1e-9) << "600 mm/min";
  EXPECT_EQ(say("\n$J=G90 Z-2 F600\n"), "ok\r\nok\r\n");
  run(3.0);
  EXPECT_EQ(controller.motion().position().z, -2.0);
  EXPECT_NE(say("$G\n").find("G90 G93"), std::string::npos);
  EXPECT_EQ(say("G91\nG94\nG1 X1 F600\n"), "ok\r\nok\r\nok\r\n");
  run(3.0);
  EXPECT_EQ(controller.motion().position().x, 7.0) << "the program goes on from where the jog has ended";
}

TEST_F(GrblOperator, RefusesJogsByNumber) {
  EXPECT_EQ(say("$J=X10\n"), "error:22\r\n");
  EXPECT_EQ(say("$J=F10\n"), "error:26\r\n");
  EXPECT_EQ(say("$J=G1X10F10\n"), "error:16\r\n");
  EXPECT_EQ(say("$J=X10M3F10\n"), "error:16\r\n");
  EXPECT_EQ(say("$J=G91X501F10\n"), "error:15\r\n");
  EXPECT_EQ(say("$20=0\n$J=G91X501F6000\n"), "ok\r\nok\r\n") << "no soft limits";
  EXPECT_EQ(say("$J=G91X-1F6000\n"), "ok\r\n");
  run(10.0);
  EXPECT_EQ(say("G1 X1 F100\n$J=G91X1F10\n"), "ok\r\nerror:8\r\n");
}

TEST_F(GrblOperator, AJogIsCancelledWithAllThatIsBehindIt) {
  for (const char* byte : {"\x85", "!"}) {
    say("$J=G91X10F600\n$J=G91X10F600\n");
    run(0.5);
    say(byte);
    run(1.0);
    EXPECT_EQ(say("?").find("<Idle|"), 0u) << byte;
    EXPECT_LT(controller.motion().position().x, 15.1);
    EXPECT_EQ(say("\x85"), "");
  }
  EXPECT_NEAR(controller.motion().position().x, 10.0, 1e-6);
  EXPECT_EQ(say("G91 G0 X1\n"), "ok\r\n");
  run(1.0);
  EXPECT_NEAR(controller.motion().position().x, 11.0, 1e-6);
}

TEST_F(GrblOperator, WorkOffsetsMoveTheProgram) {
  EXPECT_EQ(say("G10 L2 P2 X100 Z-500\nG55 G0 X1 Z2\n"), "ok\r\nok\r\n");
  run(10.0);
  EXPECT_EQ(controller.motion().position(), (Joints{101, 0, 2, 0, 0}));
  EXPECT_NE(say("?").find("MPos:101.000,0.000,-498.000,"), std::string::npos);
  EXPECT_NE(say("$G\n").find(" G55 "), std::string::npos);
  EXPECT_EQ(say("G10 L20 P0 X0\nG0 X5\n"), "ok\r\nok\r\n");
  run(10.0);
  EXPECT_EQ(controller.motion().position().x, 106.0);
  EXPECT_NE(say("$#\n").find("[G55:101.000,0.000,-500.000,0.000,0.000]\r\n"), std::string::npos);
  EXPECT_EQ(say("G59.3\nG0 X5\n"), "ok\r\nok\r\n");
  run(10.0);
  EXPECT_EQ(controller.motion().position().x, 5.0);
  EXPECT_EQ(say("G92 X0\nG0 X1\n"), "ok\r\nok\r\n");
  run(10.0);
  EXPECT_EQ(controller.motion().position().x, 6.0);
  EXPECT_EQ(say("G43.1 Z10\nG0 Z0\n"), "ok\r\nok\r\n");
  run(10.0);
  EXPECT_EQ(controller.motion().position().z, 10.0);
  EXPECT_EQ(say("G49 G92.1\nG54 G53 G0 Z0\n"), "ok\r\nok\r\n");
  run(10.0);
  EXPECT_EQ(controller.motion().position().z, 500.0) << "the top of the travel, whatever the offset";
  EXPECT_EQ(say("G55 G0 X0\nM2\n"), "ok\r\n");
  run(10.0);
  EXPECT_NE(say("$G\n").find(" G54 "), std::string::npos) << "M2 selects it";
  EXPECT_EQ(say("G10 L2 P1\n"), "error:26\r\n");
  EXPECT_EQ(say("\nG10 X1\n"), "ok\r\nerror:28\r\n");
  EXPECT_EQ(say("\nG10 L2 P10 X1\n"), "ok\r\nerror:29\r\n");
  EXPECT_EQ(say("\nG56 G0 X1 Q2\n"), "ok\r\nerror:20\r\n");
  EXPECT_NE(say("$G\n").find(" G54 "), std::string::npos) << "a refused line changes nothing";
}

TEST_F(GrblOperator, HomesZFirst) {
  EXPECT_EQ(say("$H\n"), "error:5\r\n");
  EXPECT_EQ(say("$22=1\n$H\n"), "ok\r\n");
  run(0.1);
  EXPECT_EQ(say("?").find("<Home|"), 0u);
  EXPECT_EQ(run(10.0), "ok\r\n");
  EXPECT_EQ(rows.at(0).command.target, (Joints{0, 0, 499, 0, 0}));
  EXPECT_EQ(controller.motion().position(), (Joints{499, 499, 499, 0, 0}));
}

class GrblWithPlate : public GrblOperator {
 protected:
  GrblWithPlate() : GrblOperator({.plate = -520.0}) {}
};

TEST_F(GrblWithPlate, ProbesUntilThePlate) {
  EXPECT_EQ(say("G21 G90 G94 G38.2 Z-50 F600\n"), "");
  EXPECT_EQ(run(5.0), "[PRB:0.000,0.000,-520.000,0.000,0.000:1]\r\nok\r\n");
  EXPECT_EQ(controller.motion().position().z, -20.0);
  EXPECT_NE(say("?").find("|Pn:P|"), std::string::npos);
  EXPECT_EQ(say("G38.2 Z-50 F600\n").find("ALARM:4"), 0u) << "it touches already";
  EXPECT_EQ(say("$X\nG0 Z0\n"), "[MSG:Caution: Unlocked]\r\nok\r\nok\r\n");
  run(5.0);
  EXPECT_EQ(say("G38.2 Z-10 F600\n"), "");
  EXPECT_EQ(run(5.0).find("ALARM:5\r\n"), 0u);
}

TEST_F(GrblOperator, KeepsSettings) {
  EXPECT_EQ(say("$110=1234.5\n"), "ok\r\n");
  EXPECT_NE(say("$$\n").find("$110=1234.500\r\n"), std::string::npos);
  EXPECT_EQ(say("$999=1\n"), "error:3\r\n");
  EXPECT_EQ(say("$110=x\n"), "error:3\r\n");
}

}  // namespace
}  // namespace tiltfeed::sim
