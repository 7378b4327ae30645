// What takes several commands: settings and a file, tool lengths, the guided tool change.

#include "daemon/machine/machine_guides.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <sstream>

#include "tests/peers/operator_shop.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

bool holds(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

struct Guided : OperatorShop {
  using OperatorShop::OperatorShop;
  MachineAct act = [this](const std::string& name, const std::vector<std::string>& words) {
    return ask(name, words);
  };
  std::string file(const char* what, const std::string& path) {
    const auto answer = settings_file(act, what, path);
    return answer ? answer->text : answer.error().message;
  }
};

TEST(SettingsFile, IsSavedComparedAndRestored) {
  const Folder folder("settings");
  const std::string path = folder.path + "/kept.txt";
  Guided shop;
  EXPECT_TRUE(holds(shop.file("save", path), " settings"));
  EXPECT_TRUE(holds(shop.file("compare", path), "as in the controller"));
  shop.wire("$110=100\n$22=1\n", 0.2);
  const std::string differ = shop.file("compare", path);
  EXPECT_TRUE(holds(differ, "$22: file 0, controller 1")) << differ;
  EXPECT_TRUE(holds(differ, "$110: file 6000.000, controller 100.000")) << differ;
  EXPECT_EQ(std::count(differ.begin(), differ.end(), '\n'), 2);
  EXPECT_TRUE(holds(shop.file("restore", path), "2 settings restored"));
  EXPECT_TRUE(holds(shop.file("compare", path), "as in the controller"));
  EXPECT_TRUE(holds(shop.wire("$$\n", 0.3), "$110=6000.000"));
}

/// A controller that refuses soft limits without homing, as Grbl does.
TEST(SettingsFile, WhatWantsOtherSettingsFirstIsTriedAgain) {
  const Folder folder("settings");
  const std::string path = folder.write("kept.txt", "; kept\n$20=1 ; soft limits\n\n$22=1\n$30=5\n");
  std::map<int, std::string> now{{20, "0"}, {22, "0"}, {30, "5"}};
  std::vector<int> order;
  const MachineAct act = [&](const std::string&,
                             const std::vector<std::string>& words) -> Result<MachineAnswer> {
    nlohmann::json json = {{"settings", nlohmann::json::array()}};
    for (const auto& [number, value] : now)
      json["settings"].push_back({{"number", number}, {"value", value}});
    if (words.empty()) return MachineAnswer{"", json.dump()};
    const int number = std::stoi(words[1]);
    if (number == 20 && now[22] == "0") return fail(Code::kLink, "error:10");
    if (number == 7) return fail(Code::kLink, "error:3");
    now[number] = words[1].substr(words[1].find('=') + 1);
    order.push_back(number);
    return MachineAnswer{"set", "{}"};
  };
  const auto restored = settings_file(act, "restore", path);
  ASSERT_TRUE(restored) << restored.error().message;
  EXPECT_EQ(order, (std::vector<int>{22, 20}));
  const auto refused = settings_file(act, "restore", folder.write("bad.txt", "$7=1\n$30=6\n"));
  ASSERT_FALSE(refused);
  EXPECT_TRUE(holds(refused.error().message, "error:3")) << refused.error().message;
  EXPECT_TRUE(holds(refused.error().message, "1 of 2")) << refused.error().message;
}

TEST(SettingsFile, WhatIsNoFileOfSettingsIsRefusedBeforeAnythingIsSent) {
  const Folder folder("settings");
  Guided shop;
  for (const char* text : {"", "G0 X1\n", "$110\n", "$110=1\n$110=2\n", "$x=1\n", "110=3\n"}) {
    const std::string said = shop.file("restore", folder.write("bad.txt", text));
    EXPECT_TRUE(holds(said, "bad.txt")) << said;
  }
  EXPECT_TRUE(holds(shop.file("compare", folder.path + "/none.txt"), "cannot be read"));
  // Neither waited for nor read to its end.
  ASSERT_EQ(::mkfifo((folder.path + "/pipe").c_str(), 0600), 0);
  for (const std::string& path : {folder.path + "/pipe", std::string("/dev/zero"), folder.path})
    EXPECT_TRUE(holds(shop.file("compare", path), "is not a regular file")) << path;
  EXPECT_TRUE(
      holds(shop.file("compare", folder.write("large.txt", std::string(2u << 20, 'x'))), "too large"));
  EXPECT_TRUE(shop.line.said.empty());
}

TEST(MachineTool, ParksWithSpindleAndCoolantOff) {
  Guided shop;
  shop.wire("G21 G90 G94\nG0 X5 Y6 Z-30\nM3 S1000\nM8\n", 20.0);
  ASSERT_GT(shop.controller.motion().accessories().spindle, 0.0);
  EXPECT_TRUE(holds(shop.say("tool", {"park"}), "parked: machine X5 Y6 Z0")) << shop.say("tool", {"park"});
  EXPECT_EQ(shop.at(), (Joints{5, 6, 200, 0, 0}));
  EXPECT_EQ(shop.controller.motion().accessories().spindle, 0.0);
  EXPECT_FALSE(shop.controller.motion().accessories().flood);
  shop.profile.format.retract = "none";
  EXPECT_EQ(shop.ask("tool", {"park"}).error().code, Code::kUsage);
}

/// One thing goes wrong with what the host sends.
class Losing : public Link {
 public:
  Losing(Link& wire, std::string what) : wire_(wire), what_(std::move(what)) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (!out.starts_with(what_)) return wire_.exchange(out, wait, in);
    in += "ok\r\n";
    return out.size();
  }

 private:
  Link& wire_;
  std::string what_;
};

TEST(MachineTool, IsNotParkedWhereTheSpindleTurnsOrZIsNotUp) {
  for (const char* lost : {"M5", "G53"}) {
    Guided shop;
    shop.wire("G21 G90 G94\nG0 Z-30\nM3 S1000\n", 20.0);
    Losing losing(shop.line, lost);
    const MachineBench bench{shop.profile, shop.link, losing, shop.line};
    const auto parked = perform_order(bench, "tool", {"park"});
    ASSERT_FALSE(parked) << parked->text;
    EXPECT_TRUE(holds(parked.error().message, "not parked")) << parked.error().message;
  }
}

TEST(MachineTool, LengthAndSetterAreMeasuredFromEachOther) {
  Guided shop({.plate = -220.5});
  // The plate touches where the tip is: with a tool of 80 mm the gauge line would touch 80 mm lower.
  EXPECT_EQ(shop.json("tool", {"measure", "Z-50", "F300", "length=80"})["setter"], -300.5);
  shop.wire("G0 Z0\n", 5.0);
  EXPECT_EQ(shop.json("tool", {"measure", "Z-50", "F300", "setter=-300.5"})["length"], 80.0);
  shop.wire("G0 Z0\n", 5.0);
  EXPECT_EQ(shop.ask("tool", {"measure", "Z-50", "setter=-200"}).error().code, Code::kLimit);
  for (const std::vector<std::string>& words : {std::vector<std::string>{},
                                                {"measure", "Z-5"},
                                                {"measure", "Z-5", "setter=1", "length=2"},
                                                {"measure", "Z-5", "setter=x"},
                                                {"turn"}})
    EXPECT_EQ(shop.ask("tool", words).error().code, Code::kUsage);
}

TEST(ToolChange, IsGuidedFromParkingToTheLength) {
  for (const auto& [typed, length] :
       {std::pair("\n101.5\n", 101.5), std::pair("\nZ-300 F6000 setter=-300.5\n", 80.0)}) {
    Guided shop({.plate = -220.5});
    std::istringstream in(typed);
    std::ostringstream out;
    const auto changed = change_tool(shop.act, in, out);
    ASSERT_TRUE(changed) << typed << changed.error().message;
    // From the top of its travel the probe holds to go further down.
    EXPECT_EQ(nlohmann::json::parse(changed->json)["length"], length) << changed->text;
    EXPECT_TRUE(holds(out.str(), "parked")) << out.str();
    EXPECT_TRUE(holds(changed->text, "--tool-length")) << changed->text;
  }
  for (const char* typed : {"", "\n", "\n-3\n", "\n0\n", "\nten\n"}) {
    Guided shop;
    std::istringstream in(typed);
    std::ostringstream out;
    EXPECT_FALSE(change_tool(shop.act, in, out)) << typed;
  }
}

}  // namespace
}  // namespace tiltfeed
