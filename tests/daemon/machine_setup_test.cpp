// Work offsets, probing, settings, console and overrides over a plain link. What the simulated machine holds
// afterwards is compared with what was said.

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/protocol/grbl_words.h"
#include "tests/peers/operator_shop.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

bool has(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

TEST(MachineOffsets, AreShownAndSetByValueAndFromHere) {
  OperatorShop shop;
  EXPECT_TRUE(has(shop.say("offsets"), "G54     X0 Y0 Z-200 A0 C0")) << shop.say("offsets");
  EXPECT_TRUE(has(shop.say("offsets", {"G55", "X-120.5", "C90"}), "G55 set: X-120.5 Y0 Z-200 A0 C90"));
  sim::GrblOffsets is = shop.controller.offsets();
  EXPECT_EQ(is.system(1), (sim::GrblAxes{-120.5, 0, -200, 0, 90}));
  EXPECT_EQ(is.system(0), (sim::GrblAxes{0, 0, -200, 0, 0})) << "no other one";
  EXPECT_TRUE(has(shop.say("jog", {"X10", "Z-30", "F3000"}), "jog done"));
  EXPECT_TRUE(has(shop.say("offsets", {"G59.3", "here", "X0", "Z2.5"}), "G59.3 set: X10 Y0 Z-232.5"));
  is = shop.controller.offsets();
  EXPECT_EQ(is.system(8), (sim::GrblAxes{10, 0, -232.5, 0, 0}));
  // With G92 and a tool length on top, here is still here.
  shop.wire("G92 X3\nG43.1 Z5\n", 0.2);
  EXPECT_TRUE(has(shop.say("offsets", {"G54", "here", "X1", "Z-7"}), "G54 set")) << shop.say("offsets");
  const auto place = shop.json("status")["program"];
  EXPECT_NEAR(place["X"], 1.0, 0.001) << place;
  EXPECT_NEAR(place["Z"], -7.0, 0.001) << place;
}

TEST(MachineOffsets, WhatIsNoOffsetIsRefused) {
  OperatorShop shop;
  for (const std::vector<std::string>& words : {std::vector<std::string>{"G60", "X1"},
                                                {"G54"},
                                                {"G54", "here"},
                                                {"G54", "B2"},
                                                {"G54", "F2"},
                                                {"G53", "X1"}})
    EXPECT_EQ(shop.ask("offsets", words).error().code, Code::kUsage) << words[0];
  shop.wire("G1 X100 F100\n", 0.1);
  EXPECT_TRUE(has(shop.say("offsets", {"G54", "X1"}), "needs an idle machine. Run")) << shop.say("offsets");
  EXPECT_FALSE(shop.sent("G10"));
}

/// A controller that answers ok and keeps what it had.
class Deaf : public Link {
 public:
  Deaf(Link& wire, std::string to) : wire_(wire), to_(std::move(to)) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (!out.starts_with(to_)) return wire_.exchange(out, wait, in);
    in += "ok\r\n";
    return out.size();
  }

 private:
  Link& wire_;
  std::string to_;
};

TEST(MachineOffsets, IsSetOnlyWhenItIsReadBack) {
  OperatorShop shop;
  for (const auto& [deaf_to, name, words] :
       {std::tuple("G10", "offsets", std::vector<std::string>{"G54", "X1"}),
        std::tuple("$110=", "settings", std::vector<std::string>{"set", "110=777"})}) {
    Deaf deaf(shop.line, deaf_to);
    const MachineBench bench{shop.profile, shop.link, deaf, shop.line};
    const auto set = perform_order(bench, name, words);
    ASSERT_FALSE(set) << set->text;
    EXPECT_TRUE(has(set.error().message, "the controller says")) << set.error().message;
  }
}

TEST(MachineProbe, TellsWhereItTouchedAndNotWhereItStopped) {
  OperatorShop shop({.plate = -220.5});
  shop.wire("$22=1\n", 0.1);
  const auto probe = shop.json("probe", {"Z-50", "F600"});
  EXPECT_EQ(probe["machine"]["Z"], -220.5) << probe;
  EXPECT_EQ(probe["program"]["Z"], -20.5) << probe;
  EXPECT_NEAR(shop.at().z, -20.5 - 10.0 * 10.0 / (2 * 500.0), 1e-9) << "it brakes beyond the plate";
  const std::string modal = shop.wire("$G\n", 0.1);
  EXPECT_TRUE(has(modal, "G90 G94")) << modal;
  EXPECT_EQ(shop.wire("X5\n", 0.1).find("error:26"), 0u) << "the probing is not modal any more";
}

TEST(MachineProbe, SetsTheOffsetOfThePlatesTop) {
  OperatorShop shop({.plate = -220.5});
  shop.wire("G91\n", 0.1);
  const std::string said = shop.say("probe", {"Z-50", "F60", "G55=12.25"});
  EXPECT_TRUE(has(said, "G55 set: X0 Y0 Z-232.75")) << said;
  sim::GrblOffsets is = shop.controller.offsets();
  EXPECT_EQ(is.system(1), (sim::GrblAxes{0, 0, -232.75, 0, 0}));
  EXPECT_TRUE(has(shop.wire("$G\n", 0.1), "G91")) << "as it was";
}

TEST(MachineProbe, ItsAlarmsAreTold) {
  OperatorShop shop({.plate = -220.5});
  const std::string none = shop.say("probe", {"Z-10", "F600"});
  EXPECT_TRUE(has(none, "ALARM:5: the probe touched nothing")) << none;
  EXPECT_TRUE(has(shop.say("probe", {"Z-10"}), "needs an idle machine")) << "it is locked";
  EXPECT_TRUE(has(shop.say("unlock"), "unlocked"));
  EXPECT_TRUE(has(shop.say("probe", {"Z-50", "F600"}), "touched at machine")) << "and goes on after it";
  const std::string touching = shop.say("probe", {"Z-5", "F600"});
  EXPECT_TRUE(has(touching, "ALARM:4")) << touching;
  EXPECT_TRUE(has(shop.say("unlock"), "unlocked"));
  EXPECT_EQ(shop.ask("probe", {"Z-300"}).error().code, Code::kLimit);
  EXPECT_EQ(shop.ask("probe", {"Z-3", "X2"}).error().code, Code::kUsage);
  EXPECT_EQ(shop.ask("probe", {"Z-3", "G53=1"}).error().code, Code::kUsage);
}

TEST(MachineProbe, IsStoppedOnRequest) {
  OperatorShop shop({.plate = -390.0});
  shop.bench.stopped = [&] { return shop.at().z < -10.0 && !shop.controller.motion().held(); };
  const auto probe = shop.ask("probe", {"Z-250", "F600"});
  ASSERT_FALSE(probe) << probe->text;
  EXPECT_EQ(probe.error().code, Code::kCancelled) << probe.error().message;
  EXPECT_TRUE(shop.controller.motion().idle());
  EXPECT_GT(shop.at().z, -30.0);
}

TEST(MachineSettings, AreShownByNameAndSetOne) {
  OperatorShop shop;
  const std::string shown = shop.say("settings");
  EXPECT_TRUE(has(shown, "$110=6000.000       X highest rate, mm/min, deg/min")) << shown;
  EXPECT_TRUE(has(shown, "C acceleration")) << shown;
  EXPECT_TRUE(has(shop.say("settings", {"set", "$110=4500.5"}), "set: $110=4500.500"));
  EXPECT_TRUE(has(shop.wire("$$\n", 0.3), "$110=4500.500"));
  EXPECT_TRUE(has(shop.say("settings", {"set", "999=1"}), "error:3"));
  for (const char* word : {"110", "x=1", "110=", "110=1 2", "110=!"})
    EXPECT_EQ(shop.ask("settings", {"set", word}).error().code, Code::kUsage) << word;
}

TEST(MachineConsole, GivesTheAnswerAndErrorsInWords) {
  OperatorShop shop;
  EXPECT_TRUE(has(shop.say("console", {"$I"}), "[VER:1.1h.20260801:tiltfeed-sim]"))
      << shop.say("console", {"$I"});
  EXPECT_EQ(shop.say("console", {"G0", "X5", "Y6"}), "ok");
  shop.wire("", 2.0);
  EXPECT_TRUE(has(shop.say("console", {"G1 X9"}), "error:22: no feed has been set"))
      << shop.say("console", {"G1 X9"});
  EXPECT_TRUE(has(shop.say("console", {"G0 X9999"}), "ALARM:2: the target is beyond the travel"));
  for (const char* line : {"!", "G0 X1 ?", "~", "\x18", "\x85", ""})
    EXPECT_EQ(shop.ask("console", {line}).error().code, Code::kUsage) << line;
}

TEST(MachineConsole, TakesNoAnswerToSomebodyElsesLine) {
  OperatorShop shop;
  shop.controller.receive("G4 P1\nG4 P2\n");  // answered only later, one by one
  const std::string said = shop.say("console", {"$G"});
  EXPECT_TRUE(has(said, "[GC:")) << said;
  EXPECT_FALSE(has(said, "[VER:")) << said;
}

TEST(MachineConsole, WaitsForALongLineAndNotForASilentController) {
  OperatorShop shop;
  EXPECT_EQ(shop.say("console", {"G1 X100 F300"}), "ok");
  EXPECT_TRUE(has(shop.say("console", {"G0 X0"}), "needs an idle machine. Run"));
  shop.wire("", 30.0);
  EXPECT_EQ(shop.say("console", {"M3 S1000"}), "ok");
  class Silent : public Link {
   public:
    explicit Silent(Link& wire) : wire_(wire) {}
    Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
      if (!out.starts_with("M5")) return wire_.exchange(out, wait, in);
      static_cast<void>(wire_.exchange({}, wait, in));
      return out.size();  // lost on the way
    }

   private:
    Link& wire_;
  } silent(shop.line);
  const MachineBench bench{shop.profile, shop.link, silent, shop.line};
  const auto lost = perform_order(bench, "console", {"M5"});
  ASSERT_FALSE(lost);
  EXPECT_TRUE(has(lost.error().message, "no answer to 'M5'")) << lost.error().message;
}

TEST(MachineOverride, IsSaidWhenItIsReported) {
  OperatorShop shop;
  EXPECT_EQ(shop.say("override", {"spindle", "123"}), "spindle override 123 %");
  EXPECT_EQ(shop.say("override", {"feed", "37"}), "feed override 37 %");
  EXPECT_EQ(shop.say("override", {"rapid", "25"}), "rapid override 25 %");
  EXPECT_EQ(shop.controller.motion().feed_override(), 37);
  EXPECT_EQ(shop.controller.motion().rapid_override(), 25);
  EXPECT_EQ(shop.json("status")["override"]["spindle"], 123);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"feed", "9"},
                                                {"feed", "201"},
                                                {"rapid", "70"},
                                                {"coolant", "50"},
                                                {"feed"},
                                                {"feed", "5x"}})
    EXPECT_EQ(shop.ask("override", words).error().code, Code::kUsage);
}

TEST(GrblWords, EveryNumberOfTheTablesHasWordsAndWhatToDo) {
  for (int code = 1; code <= 17; ++code) EXPECT_TRUE(has(grbl_error_text(code), "; ")) << code;
  for (int code = 20; code <= 58; ++code) EXPECT_TRUE(has(grbl_error_text(code), "; ")) << code;
  for (int code = 1; code <= 22; ++code) EXPECT_TRUE(has(grbl_alarm_text(code), "; ")) << code;
  EXPECT_EQ(grbl_error_text(250), "error:250");
  EXPECT_EQ(reply_meaning("error:22").find(": no feed"), 0u);
  EXPECT_EQ(reply_meaning("ALARM:1").find(": a limit switch"), 0u);
  for (const char* line : {"error:", "error", "ALARM:999", "error:x"})
    EXPECT_EQ(reply_meaning(line), "") << line;
  EXPECT_EQ(grbl_setting_name(113, "XYZAC").name, "A highest rate");
  EXPECT_EQ(grbl_setting_name(114, "XYZAC").name, "C highest rate");
  EXPECT_EQ(grbl_setting_name(115, "XYZAC").name, "");
  EXPECT_EQ(grbl_setting_name(132, "").name, "Z travel");
  EXPECT_TRUE(has(marlin_meaning("Error:checksum mismatch, Last Line: 5"), "cable"));
  EXPECT_EQ(marlin_meaning("Error:something else"), "");
}

}  // namespace
}  // namespace tiltfeed
