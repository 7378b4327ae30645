// What an operator asks of a RepRap firmware (Marlin): the same commands, proved by M400 and M114.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/machine/machine_guides.h"
#include "daemon/machine/reprap_talk.h"
#include "daemon/protocol/reprap_session.h"
#include "tests/peers/operator_shop.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

testing::AssertionResult has(const std::string& text, const std::string& what) {
  if (text.find(what) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << what << "' is not in '" << text << "'";
}

struct RepRapShop {
  explicit RepRapShop(const sim::RepRapOptions& options = {}, const sim::FaultScript& faults = {})
      : controller(shop_machine(), {}, options, [this](const sim::TraceRow& row) { rows.push_back(row); }),
        line(controller, faults, 10.0 / 115200) {
    profile.model = shop_machine();
  }
  std::string say(const std::string& name, const std::vector<std::string>& words = {}) {
    const auto answer = ask(name, words);
    return answer ? answer->text : "refused: " + answer.error().message;
  }
  Result<MachineAnswer> ask(const std::string& name, const std::vector<std::string>& words = {}) {
    return perform_order(bench, name, words);
  }
  void wire(const std::string& bytes, double seconds) {
    controller.receive(bytes);
    std::string in;
    for (const double end = line.time + seconds; line.time < end;)
      static_cast<void>(line.exchange({}, std::chrono::milliseconds(10), in));
  }
  Joints at() const { return controller.motion().position(); }
  bool sent(const std::string& text) const { return has(line.said, text); }

  std::vector<sim::TraceRow> rows;
  sim::RepRapController controller;
  VirtualLine<sim::RepRapController> line;
  MachineProfile profile;
  LinkSpec link = *parse_link("reprap:/dev/null@115200");
  MachineBench bench{profile, link, line, line};
};

sim::RepRapOptions without_emergency_parser() {
  sim::RepRapOptions options;
  options.emergency_parser = false;
  return options;
}

TEST(RepRapOrders, StatusTellsThePlaceOnceItStands) {
  RepRapShop shop;
  shop.wire("G21\nG90\nG0 X10 Y-2.5 Z-30 A12.5 C-760\n", 60.0);
  const std::string said = shop.say("status");
  EXPECT_TRUE(has(said, "state    it stands")) << said;
  EXPECT_TRUE(has(said, "program  X10 Y-2.5 Z-30 A12.5 C-760")) << said;
  EXPECT_TRUE(has(said, "-40 degrees, 2 turns back")) << said;
  EXPECT_TRUE(has(said, "Marlin")) << said;
  shop.wire("G1 X200 F60\n", 0.1);
  const std::string moving = shop.say("status");
  EXPECT_TRUE(has(moving, "Busy: it moves")) << moving;
  EXPECT_FALSE(has(moving, "program")) << moving;
  // What it had in its queue is nobody's answer afterwards.
  EXPECT_TRUE(has(shop.say("jog", {"Y1"}), "the firmware is still at work"));
  shop.wire("", 200.0);
  EXPECT_TRUE(has(shop.say("jog", {"Y1"}), "jog done: program X200 Y-1.5"));
}

TEST(RepRapOrders, AJogEndsWhereItLeads) {
  for (const sim::RepRapOptions& options : {sim::RepRapOptions{}, without_emergency_parser()}) {
    RepRapShop shop(options);
    EXPECT_TRUE(has(shop.say("jog", {"X10.5", "C-30", "F1200"}), "jog done: program X10.5 Y0 Z0 A0 C-30"));
    EXPECT_EQ(shop.at(), (Joints{10.5, 0, 0, 0, -30}));
    for (const auto& [words, code] : {std::pair(std::vector<std::string>{"X200"}, Code::kLimit),
                                      {{"Z-300.1"}, Code::kLimit},
                                      {{"X1", "F6001"}, Code::kLimit},
                                      {{"X1", "C10", "F600"}, Code::kLimit},  // C at 6000 degrees a minute
                                      {{"X0.01"}, Code::kLimit},
                                      {{"B1"}, Code::kUsage},
                                      {{"F100"}, Code::kUsage}}) {
      const auto refused = shop.ask("jog", words);
      ASSERT_FALSE(refused) << words[0];
      EXPECT_EQ(refused.error().code, code) << refused.error().message;
    }
    EXPECT_EQ(shop.at(), (Joints{10.5, 0, 0, 0, -30}));
  }
}

TEST(RepRapOrders, AJogIsStoppedOnRequest) {
  for (const sim::RepRapOptions& options : {sim::RepRapOptions{}, without_emergency_parser()}) {
    RepRapShop shop(options);
    shop.bench.stopped = [&] { return shop.at().x > 20.0; };
    const auto ended = shop.ask("jog", {"X150", "F600"});
    ASSERT_FALSE(ended) << ended->text;
    EXPECT_EQ(ended.error().code, Code::kCancelled) << ended.error().message;
    EXPECT_TRUE(has(ended.error().message, "stopped on request at program X2")) << ended.error().message;
    EXPECT_TRUE(shop.controller.motion().idle());
    // 10 mm/s: a piece of 0.25 s and the way to brake.
    EXPECT_LT(shop.at().x, 23.0);
    shop.bench.stopped = [] { return false; };
    EXPECT_TRUE(has(shop.say("jog", {"X-1"}), "jog done"));
  }
}

TEST(RepRapOrders, AContinuousJogEndsWithTheHandOrTheTravel) {
  RepRapShop shop;
  shop.bench.held = [&] { return shop.at().y < 15.0; };
  EXPECT_TRUE(has(shop.say("jog", {"y+", "F1200"}), "jog done: program X0 Y"));
  EXPECT_GE(shop.at().y, 15.0);
  EXPECT_LE(shop.at().y, 20.1);  // one piece of 0.25 s more: 5 mm
  shop.bench.held = [] { return true; };
  EXPECT_TRUE(has(shop.say("jog", {"Y+", "F6000"}), "at the end of its travel"));
  EXPECT_NEAR(shop.at().y, 200.0, 1e-9);
  // A sender that dies leaves one piece: nothing more was ever sent.
  shop.wire("", 30.0);
  EXPECT_NEAR(shop.at().y, 200.0, 1e-9);
}

TEST(RepRapOrders, WhatTheFirmwareCutsShortIsNotDone) {
  RepRapShop shop;
  shop.controller.stop_after_error();
  const std::string said = shop.say("jog", {"X5"});
  EXPECT_TRUE(has(said, "Printer stopped due to errors")) << said;
  EXPECT_TRUE(has(said, "machine unlock")) << said;
  EXPECT_EQ(shop.at().x, 0.0);
  EXPECT_TRUE(has(shop.say("unlock"), "M999 was taken"));
  EXPECT_TRUE(has(shop.say("jog", {"X5"}), "jog done"));
  // Soft limits: the firmware takes the line and stops on the way.
  class Clamped : public Link {
   public:
    explicit Clamped(Link& wire) : wire_(wire) {}
    Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
      const std::string text(out.substr(0, out.find('\n') == out.npos ? out.size() : out.find('\n') + 1));
      if (const std::size_t at = text.find("G1 X"); at != text.npos && text.find("X8") != text.npos) {
        const std::string number = text.substr(1, at - 1);
        const auto taken = wire_.exchange(reprap_frame(std::stoull(number), "G1 X7 F500") + "\n", wait, in);
        return taken ? Result<std::size_t>(out.size()) : taken;
      }
      return wire_.exchange(out, wait, in);
    }
    Link& wire_;
  } clamped(shop.line);
  const MachineBench bench{shop.profile, shop.link, clamped, shop.line};
  const auto cut = perform_order(bench, "jog", {"X3"});
  ASSERT_FALSE(cut) << cut->text;
  EXPECT_TRUE(has(cut.error().message, "the machine stands at program X7")) << cut.error().message;
}

TEST(RepRapOrders, HomesAndSaysWhereThatIs) {
  RepRapShop shop;
  shop.wire("G0 X30 Y20\n", 10.0);
  EXPECT_TRUE(has(shop.say("home", {"X"}), "homed X: program X0 Y20"));
  EXPECT_TRUE(has(shop.say("home"), "homed: program X0 Y0 Z0 A0 C0"));
  EXPECT_EQ(shop.at(), Joints{});
  EXPECT_TRUE(has(shop.say("home", {"Q"}), "refused"));
}

TEST(RepRapOrders, AHaltedFirmwareIsNamed) {
  RepRapShop shop;
  EXPECT_TRUE(has(shop.say("jog", {"X1"}), "jog done"));
  shop.controller.halt();
  for (const char* name : {"status", "unlock", "home"}) {
    const std::string said = shop.say(name);
    EXPECT_TRUE(has(said, "halted")) << name << ": " << said;
    EXPECT_TRUE(has(said, "reset")) << name << ": " << said;
  }
  shop.controller.reset();
  EXPECT_TRUE(has(shop.say("jog", {"X1"}), "has restarted when its port was opened"));
}

TEST(RepRapOrders, OffsetsAreSetFromHereWhereTheFirmwareHasThem) {
  RepRapShop shop;
  shop.wire("G90\nG0 X30 Y20\n", 10.0);
  const std::string set = shop.say("offsets", {"G55", "here", "X0", "Y5.5"});
  EXPECT_TRUE(has(set, "G55 set: here is program X0 Y5.5 Z0")) << set;
  EXPECT_TRUE(has(set, "G55 is in force now")) << set;
  EXPECT_TRUE(has(shop.say("jog", {"X2"}), "jog done: program X2 Y5.5"));
  EXPECT_EQ(shop.at().x, 32.0);
  EXPECT_FALSE(shop.ask("jog", {"X199"})) << "the travel holds in program coordinates";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{}, {"G55", "X1"}, {"G60", "here", "X1"}, {"G55", "here"}})
    EXPECT_TRUE(has(shop.say("offsets", words), "refused"));
  sim::RepRapOptions plain;
  plain.work_systems = false;
  RepRapShop printer(plain);
  EXPECT_TRUE(has(printer.say("offsets", {"G55", "here", "X3"}), "Unknown command"));
  EXPECT_TRUE(has(printer.say("offsets", {"G92", "here", "X3"}), "G92 set: here is program X3"));
}

TEST(RepRapOrders, SettingsAreShownSetKeptAndCompared) {
  const Folder folder("settings");
  const std::string path = folder.path + "/kept.txt";
  RepRapShop shop;
  const MachineAct act = [&](const std::string& name, const std::vector<std::string>& words) {
    return shop.ask(name, words);
  };
  const auto file = [&](const char* what) {
    const auto answer = settings_file(act, what, path);
    return answer ? answer->text : "refused: " + answer.error().message;
  };
  EXPECT_TRUE(has(shop.say("settings"), "M203 X500.00 Y500.00 Z50.00"));
  EXPECT_TRUE(has(file("save"), "3 settings"));
  EXPECT_TRUE(has(shop.say("settings", {"set", "M203", "X400", "Y500", "Z50"}), "set: M203 X400"));
  EXPECT_TRUE(shop.sent("M500"));
  const std::string differ = file("compare");
  EXPECT_TRUE(has(differ, "M203: file X500.00 Y500.00 Z50.00, controller X400 Y500 Z50")) << differ;
  EXPECT_TRUE(has(file("restore"), "1 settings restored, 2 were as in the file"));
  EXPECT_TRUE(has(file("compare"), "as in the controller"));
  const std::size_t before = shop.line.said.size();
  for (const std::vector<std::string>& words : {std::vector<std::string>{"set", "M3", "S1000"},
                                                {"set", "G1", "X5"},
                                                {"set", "M203"},
                                                {"set", "M203", "X1*7"},
                                                {"set", "110=5"}})
    EXPECT_TRUE(has(shop.say("settings", words), "refused")) << words[1];
  EXPECT_FALSE(has(shop.line.said.substr(before), "S1000"));
  EXPECT_EQ(shop.controller.motion().accessories().spindle, 0.0);
}

TEST(RepRapOrders, ConsoleOverrideAndParking) {
  RepRapShop shop;
  EXPECT_TRUE(has(shop.say("console", {"M114"}), "X:0.00 Y:0.00"));
  const std::string unknown = shop.say("console", {"M9999"});
  EXPECT_TRUE(has(unknown, "Unknown command")) << unknown;
  for (const char* line : {"N5 G1 X1", "G1 X1*33", "M110 N0", "G1\nG1"})
    EXPECT_TRUE(has(shop.say("console", {line}), "refused")) << line;
  EXPECT_TRUE(has(shop.say("override", {"feed", "55"}), "feed override 55 %"));
  EXPECT_EQ(shop.controller.motion().feed_override(), 55);
  EXPECT_TRUE(has(shop.say("override", {"spindle", "55"}), "a feed override only"));
  shop.wire("G90\nM3 S1000\nM8\nG0 X5 Z-30\n", 10.0);
  EXPECT_TRUE(has(shop.say("tool", {"park"}), "parked: program X5"));
  EXPECT_EQ(shop.at().z, 200.0);
  EXPECT_EQ(shop.controller.motion().accessories().spindle, 0.0);
  EXPECT_FALSE(shop.controller.motion().accessories().flood);
  EXPECT_TRUE(has(shop.say("tool", {"measure", "Z-5", "setter=0"}), "park and change"));
  const std::string probe = shop.say("probe", {"Z-5"});
  EXPECT_TRUE(has(probe, "probe is not possible over reprap:")) << probe;
  EXPECT_TRUE(has(probe, "status, jog, home, unlock, offsets, settings, console, tool, override")) << probe;
}

/// Nothing is believed that another sender left, and a noisy wire changes no place.
TEST(RepRapOrders, LeftoversAndANoisyWireMisleadNothing) {
  RepRapShop shop;
  shop.controller.receive("G4 P0.5\nG1 X3 F600\nM105\nG1 X");  // answers that nobody has read, half a line
  EXPECT_TRUE(has(shop.say("jog", {"Y2"}), "jog done: program X3 Y2"));
  const sim::FaultScript noisy =
      *sim::parse_fault_script("seed 7\ncorrupt to-machine p=0.004\nlose-ok p=0.05\n", "noisy");
  RepRapShop bad({}, noisy);
  int done = 0;
  for (int i = 1; i <= 40; ++i) {
    const auto answer = bad.ask("jog", {"X1", "F6000"});
    if (!answer) continue;
    ++done;
    EXPECT_NEAR(bad.at().x, std::round(bad.at().x), 1e-9);
    EXPECT_EQ(nlohmann::json::parse(answer->json)["program"]["X"], bad.at().x);
  }
  EXPECT_GE(done, 30);
  EXPECT_GT(bad.controller.totals().resends, 3u);
}

TEST(OtherLinks, SayWhatTheyCan) {
  RepRapShop shop;
  shop.link = *parse_link("dnc:/dev/null");
  for (const MachineOrder& one : machine_orders()) {
    const std::string said = shop.say(one.name, {"X1"});
    EXPECT_TRUE(
        has(said, "is not possible over dnc:/dev/null@9600, do it at the control; nothing but a program"))
        << said;
  }
  shop.link = *parse_link("drive-tcp:127.0.0.1:502");
  EXPECT_TRUE(has(shop.say("jog", {"X1"}), "status, and `tiltfeed reset` are possible there"));
  EXPECT_TRUE(shop.line.said.empty());
}

}  // namespace
}  // namespace tiltfeed
