// What an operator asks of a machine: state, jogs, homing, unlocking. The simulated machine says what was
// really done.

#include <gtest/gtest.h>

#include "tests/peers/operator_shop.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

bool has(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

TEST(MachineStatus, TellsBothPositionsAndUnwindsRotaries) {
  OperatorShop shop;
  shop.wire("G10 L2 P1 X5 Z-180\nG21 G90 G94\nG0 X10 Y-2.5 Z-30 A12.5 C-760\n", 30.0);
  const auto status = shop.json("status");
  EXPECT_EQ(status["state"], "Idle") << status;
  EXPECT_EQ(status["program"]["C"], -760.0);
  EXPECT_EQ(status["program"]["Z"], -30.0);
  EXPECT_EQ(status["machine"]["Z"], -210.0);
  EXPECT_EQ(status["machine"]["X"], 15.0);
  EXPECT_EQ(status["rotaries"]["C"]["angle"], -40.0);
  EXPECT_EQ(status["rotaries"]["C"]["turns"], -2);
  const std::string text = shop.say("status");
  EXPECT_TRUE(has(text, "-40 degrees, 2 turns back")) << text;
  EXPECT_TRUE(has(text, "Idle: ready")) << text;
}

TEST(MachineStatus, TellsAnAlarmInWords) {
  OperatorShop shop;
  shop.wire("G90 G0 X9999\n", 1.0);
  const std::string text = shop.say("status");
  EXPECT_TRUE(has(text, "Alarm")) << text;
  EXPECT_TRUE(has(text, "unlock it")) << text;
}

TEST(MachineJog, EndsWhereItLeadsAndLeavesTheModalStateAlone) {
  OperatorShop shop;
  shop.wire("G21 G90 G93\n", 0.1);
  EXPECT_TRUE(has(shop.say("jog", {"X10.5", "C-90", "F3000"}), "jog done: program X10.5"));
  EXPECT_EQ(shop.at(), (Joints{10.5, 0, 0, 0, -90}));
  EXPECT_TRUE(has(shop.say("jog", {"x-0.001"}), "jog done"));
  EXPECT_DOUBLE_EQ(shop.at().x, 10.499);
  const std::string modal = shop.wire("$G\n", 0.1);
  EXPECT_TRUE(has(modal, "G90 G93")) << modal;
  ASSERT_EQ(shop.rows.size(), 2u);
  // 10.5 mm and 90 degrees at 3000 a minute over all axes.
  EXPECT_GE(shop.rows[0].end - shop.rows[0].start, std::hypot(10.5, 90.0) / 50.0);
}

TEST(MachineJog, TheProfilesLimitsHold) {
  OperatorShop shop;
  for (const std::vector<std::string>& words : {std::vector<std::string>{"X201"},
                                                {"Z-300.1"},
                                                {"A110.5"},
                                                {"Y200", "X-300.5"},
                                                {"X1", "F6001"},
                                                {"C1", "F3601"}}) {
    const auto refused = shop.ask("jog", words);
    ASSERT_FALSE(refused) << words[0];
    EXPECT_EQ(refused.error().code, Code::kLimit) << refused.error().message;
  }
  EXPECT_FALSE(shop.sent("$J")) << "nothing is sent";
  // In program coordinates: with another work offset the same axis has other room.
  shop.wire("G10 L2 P1 X100 Z-200\n", 0.5);
  EXPECT_FALSE(shop.ask("jog", {"X-250"}));
  EXPECT_FALSE(shop.sent("$J"));
  EXPECT_TRUE(shop.ask("jog", {"X-199"}));
  EXPECT_TRUE(shop.ask("jog", {"X1"}));
}

TEST(MachineJog, WordsThatItDoesNotTakeAreRefused) {
  OperatorShop shop;
  for (const std::vector<std::string>& words : {std::vector<std::string>{},
                                                {"F100"},
                                                {"B1"},
                                                {"X1", "X2"},
                                                {"X"},
                                                {"X1e3"},
                                                {"X1", "F0"},
                                                {"X1\nG0X5"},
                                                {"X+", "Y+"},
                                                {"Q+"},
                                                {"Xnan"},
                                                {"!"}}) {
    const auto refused = shop.ask("jog", words);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::kUsage) << refused.error().message;
  }
  EXPECT_TRUE(shop.line.said.empty());
  EXPECT_FALSE(shop.ask("joog"));
}

TEST(MachineJog, NothingThatOthersLeftMisleadsIt) {
  OperatorShop shop;
  shop.wire("G4 P0.2\nG90\nG999\nG1 X",
            0.0);  // answers that nobody has read, an error that latches, half a line
  shop.wire("", 0.5);
  const std::string text = shop.say("jog", {"Y2"});
  EXPECT_TRUE(has(text, "jog done")) << text;
  EXPECT_EQ(shop.at(), (Joints{0, 2, 0, 0, 0}));
}

TEST(MachineJog, EndedAtTheMachineIsNotDone) {
  OperatorShop shop;
  int polls = 0;
  shop.bench.stopped = [&] {
    if (++polls == 60) shop.controller.receive("!");  // its own hold button
    return false;
  };
  const auto ended = shop.ask("jog", {"X150", "F600"});
  ASSERT_FALSE(ended) << ended->text;
  EXPECT_TRUE(has(ended.error().message, "not where the jog leads")) << ended.error().message;
  EXPECT_LT(shop.at().x, 149.0);
}

TEST(MachineJog, IsStoppedOnRequest) {
  OperatorShop shop;
  int polls = 0;
  shop.bench.stopped = [&] { return ++polls > 60; };
  const auto ended = shop.ask("jog", {"X150", "F600"});
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, Code::kCancelled);
  EXPECT_TRUE(has(ended.error().message, "stopped on request at program X")) << ended.error().message;
  EXPECT_TRUE(shop.controller.motion().idle());
  EXPECT_GT(shop.at().x, 0.0);
  EXPECT_LT(shop.at().x, 149.0);
  shop.bench.stopped = [] { return false; };
  EXPECT_TRUE(shop.ask("jog", {"X-1"})) << "the machine is not left in a hold";
}

/// Answers everything with ok and stands where it stands.
class Frozen : public Link, public Clock {
 public:
  Time now() override { return time_; }
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    for (const char c : out) {
      if (c == '?') in += "<Idle|MPos:0.000,0.000,0.000,0.000,0.000|WCO:0.000,0.000,0.000,0.000,0.000>\r\n";
      if (c == '\n') in += out.starts_with("$I") ? "[VER:1.1h:]\r\nok\r\n" : "ok\r\n";
    }
    time_ += out.empty() ? std::max<Time>(wait, std::chrono::milliseconds(1)) : Time(1000000);
    return out.size();
  }

 private:
  Time time_{};
};

TEST(MachineJog, AMachineThatAnswersAndDoesNotMoveHasNotJogged) {
  OperatorShop shop;
  Frozen frozen;
  const MachineBench bench{shop.profile, shop.link, frozen, frozen};
  for (const char* way : {"X50", "X0.01", "X0.05"}) {
    const auto jogged = perform_order(bench, "jog", {way});
    ASSERT_FALSE(jogged) << way << ": " << jogged->text;
    EXPECT_TRUE(has(jogged.error().message, "not where the jog leads")) << jogged.error().message;
  }
}

/// The way to the machine is whole, the way back is not.
class HalfLink : public Link {
 public:
  HalfLink(Link& wire, const double& time, double from) : wire_(wire), time_(time), from_(from) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    std::string lost;
    return wire_.exchange(out, wait, time_ < from_ ? in : lost);
  }

 private:
  Link& wire_;
  const double &time_, from_;
};

TEST(MachineJog, OneOfWhichNothingIsHeardAnyMoreIsCancelled) {
  OperatorShop shop;
  HalfLink wire(shop.line, shop.line.time, 2.0);
  const MachineBench bench{shop.profile, shop.link, wire, shop.line};
  const auto jogged = perform_order(bench, "jog", {"X190", "F60"});
  ASSERT_FALSE(jogged);
  EXPECT_NE(jogged.error().message.find("a cancel of the jog was sent"), std::string::npos)
      << jogged.error().message;
  shop.wire("", 1.0);
  EXPECT_TRUE(shop.controller.motion().idle());
  EXPECT_GT(shop.at().x, 1.0);
  EXPECT_LT(shop.at().x, 60.0) << "it has not gone on";
}

TEST(MachineJog, GoesOnWhileItIsHeldAndBrakesThen) {
  OperatorShop shop;
  const double begun = shop.line.time;
  shop.bench.held = [&] { return shop.line.time - begun < 3.0; };
  const auto jogged = shop.ask("jog", {"X-", "F1200"});
  ASSERT_TRUE(jogged) << jogged.error().message;
  EXPECT_LT(shop.at().x, -20.0);
  EXPECT_GT(shop.at().x, -65.0) << "20 mm a second";
  EXPECT_TRUE(shop.controller.motion().idle());
  EXPECT_FALSE(shop.controller.motion().held());
}

TEST(MachineJog, AContinuousJogStopsAtTheEndOfTravel) {
  OperatorShop shop;
  shop.wire("G90 G0 X190.0004\n", 3.0);
  shop.bench.held = [] { return true; };
  const auto jogged = shop.ask("jog", {"X+", "F1200"});
  ASSERT_TRUE(jogged) << jogged.error().message;
  EXPECT_TRUE(has(jogged->text, "end of its travel")) << jogged->text;
  EXPECT_NEAR(shop.at().x, 200.0, 0.002);
  EXPECT_LE(shop.at().x, 200.0 + 1e-9);
}

/// The dead man's part that no timeout of a live sender covers: the sender itself dies.
TEST(MachineJog, ASenderThatDiesLeavesAFractionOfASecond) {
  class Dying : public Link {
   public:
    Dying(VirtualLine<sim::GrblController>& wire, double at) : wire_(wire), at_(at) {}
    Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
      if (wire_.time > at_) return fail(Code::kLink, "killed");
      return wire_.exchange(out, wait, in);
    }

   private:
    VirtualLine<sim::GrblController>& wire_;
    double at_;
  };
  for (const double feed : {300.0, 1200.0, 6000.0}) {
    OperatorShop shop;
    Dying dying(shop.line, 2.5);
    MachineBench bench{shop.profile, shop.link, dying, shop.line};
    bench.held = [] { return true; };
    EXPECT_FALSE(perform_order(bench, "jog", {"X-", "F" + std::to_string(feed)}));
    const double dead = shop.at().x, speed = feed / 60.0;
    EXPECT_LT(dead, -speed) << "it jogged";
    shop.wire("", 30.0);
    EXPECT_TRUE(shop.controller.motion().idle());
    const double left = dead - shop.at().x;
    EXPECT_LE(left, speed * 0.36 + speed * speed / (2 * 500.0)) << feed;
  }
}

TEST(MachineHome, SaysHomedWhenTheMachineIsIdleAtHome) {
  OperatorShop shop;
  EXPECT_TRUE(has(shop.say("home"), "error:5: homing is switched off")) << shop.say("home");
  shop.wire("$22=1\n", 0.2);
  shop.wire("G90 G0 X9999\n", 0.5);
  shop.controller.receive("\x18");
  EXPECT_TRUE(has(shop.say("home"), "homed: machine X199 Y199 Z-1 A0 C0"));
  EXPECT_EQ(shop.at(), (Joints{199, 199, 199, 0, 0}));
  EXPECT_EQ(shop.controller.alarm(), 0);
}

TEST(MachineHome, AHomingThatFailsIsToldWithWhatToDo) {
  OperatorShop shop({.home_switches = false});
  shop.wire("$22=1\n", 0.2);
  const auto homed = shop.ask("home");
  ASSERT_FALSE(homed) << homed->text;
  EXPECT_TRUE(has(homed.error().message, "ALARM:9: homing did not find the limit switch"))
      << homed.error().message;
}

TEST(MachineHome, IsStoppedByAResetOnRequest) {
  OperatorShop shop;
  shop.wire("$22=1\nG90 G0 X-200\n", 5.0);
  shop.bench.stopped = [&] { return shop.controller.motion().running() != nullptr; };
  const auto homed = shop.ask("home");
  ASSERT_FALSE(homed) << homed->text;
  EXPECT_EQ(homed.error().code, Code::kCancelled);
  EXPECT_EQ(shop.controller.alarm(), 6);
  EXPECT_TRUE(shop.controller.motion().idle());
}

TEST(MachineUnlock, LeavesAnAlarmAndSaysWhatItIsWorth) {
  OperatorShop shop;
  EXPECT_TRUE(has(shop.say("unlock"), "not locked"));
  EXPECT_FALSE(shop.sent("$X"));
  shop.wire("G90 G0 X9999\n", 0.5);
  EXPECT_TRUE(has(shop.say("unlock"), "error:9")) << "this alarm wants a reset first";
  shop.wire("\x18", 0.5);
  EXPECT_TRUE(has(shop.say("jog", {"X1"}), "needs an idle machine"));
  EXPECT_TRUE(has(shop.say("unlock"), "unlocked: Idle"));
  EXPECT_TRUE(has(shop.say("jog", {"X1"}), "jog done"));
}

}  // namespace
}  // namespace tiltfeed
