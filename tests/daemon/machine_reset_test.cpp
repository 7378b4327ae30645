// The order that leads out of every state, on the simulated machines: whatever they are left in, afterwards a
// program runs to its end.

#include "daemon/machine/machine_orders.h"
#include "daemon/machine/machine_place.h"

#include <gtest/gtest.h>

#include "tests/peers/line_run.h"
#include "tests/peers/ring_wire.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr const char* kSmall = "G21 G90 G94\nG0 X1 Y2 Z30 A1 C2\nM3 S500\nG1 X2 F600\nM5\nM2\n";

/// A controller of the Grbl family and whoever is at its wire.
struct GrblShop {
  sim::GrblController controller{wide_machine(), {}, {}, [this](const sim::TraceRow&) { ++executed; }};
  VirtualLine<sim::GrblController> line{controller, {}, 10.0 / 115200};
  LinkSpec link = *parse_link("grbl:/dev/null@115200");
  std::size_t executed = 0;

  void say(const std::string& bytes, double seconds) {
    std::string in, out = bytes;
    for (const double end = line.time + seconds; line.time < end;) {
      const auto taken = line.exchange(out, std::chrono::milliseconds(10), in);
      out.erase(0, *taken);
    }
  }
};

constexpr const char* kMoves =
    "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nM8\nG1 X100 F600\nG1 X0\nG1 X100\nG1 X0\n";

TEST(MachineReset, GrblIsLedOutOfEveryState) {
  struct State {
    const char *name, *bytes, *shown;
    bool homed;
  };
  for (const State& state :
       {State{"idle", "", "Idle", true}, State{"runs without a sender", kMoves, "Run", true},
        State{"held by a sender that is gone", "held", "Hold:0", true},
        State{"check mode", "$C\n", "Check", true}, State{"an error that latches", "G999\n", "Idle", true},
        State{"alarm", "G90 G0 X9999\n", "Alarm", false},
        State{"a line that was cut off", "G1 X", "Idle", true}}) {
    const Folder folder("reset");
    const std::string path = folder.write("small.nc", kSmall);
    GrblShop shop;
    const bool held = std::string(state.bytes) == "held";
    shop.say(held ? kMoves : state.bytes, 2.0);
    if (held) shop.say("!", 2.0);
    shop.controller.take_output();
    shop.controller.receive("?");
    const std::string shown = shop.controller.take_output();
    ASSERT_NE(shown.find(std::string("<") + state.shown), std::string::npos) << state.name << ": " << shown;
    const auto reset = reset_machine(shop.link, shop.line, shop.line);
    ASSERT_TRUE(reset) << state.name << ": " << reset.error().message;
    EXPECT_EQ(reset->find("home it") == reset->npos, state.homed) << state.name << ": " << *reset;
    EXPECT_EQ(shop.controller.alarm(), 0) << state.name;
    EXPECT_TRUE(shop.controller.motion().idle()) << state.name;
    EXPECT_EQ(shop.controller.motion().accessories().spindle, 0.0) << state.name;
    EXPECT_FALSE(shop.controller.motion().accessories().flood) << state.name;
    const std::size_t before = shop.executed;
    shop.say("~", 5.0);
    EXPECT_EQ(shop.executed, before) << state.name << ": a cycle start ran what was left";
    const auto report = send_over(path, shop.link, shop.line, shop.line, {}, {});
    EXPECT_TRUE(report) << state.name << ": " << report.error().message;
  }
}

/// A fault in mid-program ends so, too: nothing runs on, spindle and coolant are off where it stands.
TEST(HoldOfItsOwn, AFaultOnGrblEndsWithTheBufferEmptiedAndTheSpindleOff) {
  const Folder folder("reset");
  std::string program = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nM8\nG1 F600\n";
  for (int i = 1; i <= 600; ++i) program += (i == 300 ? "G999 X" : "G1 X") + std::to_string(i % 2 * 3) + "\n";
  const std::string path = folder.write("part.nc", program + "M5\nM2\n");
  GrblShop shop;
  const auto report = send_over(path, shop.link, shop.line, shop.line, {}, {});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("spindle and coolant are off"), std::string::npos)
      << report.error().message;
  EXPECT_EQ(shop.controller.motion().accessories().spindle, 0.0);
  EXPECT_FALSE(shop.controller.motion().accessories().flood);
  EXPECT_TRUE(shop.controller.motion().idle());
  EXPECT_EQ(shop.controller.alarm(), 0) << "the position is kept";
  const std::size_t done = shop.executed;
  shop.say("~", 30.0);
  EXPECT_EQ(shop.executed, done) << "the machine's own cycle start ran stale blocks";
  EXPECT_TRUE(send_over(folder.write("small.nc", kSmall), shop.link, shop.line, shop.line, {}, {}));
}

/// After an orderly stop the range is told by where the axes stand: a line or two, not the planner's depth.
TEST(OrderlyStop, TheRangeIsWhatPassesWhereTheAxesStand) {
  for (const bool numbers : {false, true}) {
    const Folder folder("reset");
    std::string program = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 F600\n";
    for (int i = 1; i <= 900; ++i) program += "G1 X" + std::to_string(i) + "\n";
    const std::string path = folder.write("part.nc", program + "M2\n");
    GrblShop shop;
    shop.link.profile.line_numbers = numbers;
    CommandQueue orders;
    SendState last;
    StreamHooks hooks;
    hooks.commands = &orders;
    bool told = false;
    hooks.progress = [&](const SendState& state) {
      last = state;
      if (!told && shop.executed > 57) orders.push({Order::kStop}), told = true;
      return true;
    };
    const auto report = send_over(path, shop.link, shop.line, shop.line, {}, hooks);
    ASSERT_FALSE(report);
    ASSERT_EQ(last.phase, Phase::kStopped) << report.error().message;
    EXPECT_LE(last.sent, last.executed + 2);
    // The block in which it stands is the one after those that were executed to their ends.
    const std::size_t run = shop.executed + 2;  // two lines are no blocks
    EXPECT_LE(last.executed, run);
    EXPECT_GE(last.sent, run);
    EXPECT_LE(last.uncertain.last - last.uncertain.first, 1u);
  }
}

struct RingShop {
  std::size_t executed = 0;
  RingWire wire{wide_machine(), {}, {}, SeededBug::kNone, [this](const sim::TraceRow&) { ++executed; }};
  LinkSpec link = *parse_link("modbus-rtu:/dev/null@115200");

  void wait(double seconds) {
    std::string in;
    static_cast<void>(wire.exchange({}, time_of(seconds), in));
  }
  std::uint16_t state() {
    std::array<std::uint16_t, kStatusWords> words{};
    EXPECT_EQ(wire.controller.read(sim::kStatusAt, words), sim::Access::kOk);
    return words[7];
  }
};

TEST(MachineReset, TheRingIsLedOutOfEveryState) {
  const Folder folder("reset");
  std::string program = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nG1 F600\n";
  for (int i = 1; i <= 60; ++i) program += "G1 X" + std::to_string(i % 2 * 30) + "\n";
  const std::string path = folder.write("part.nc", program + "M2\n"),
                    small = folder.write("small.nc", kSmall);
  const std::string alarm = folder.write("alarm.nc", "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X9999 F100\nM2\n");
  struct State {
    const char* name;
    int shown;
  };
  for (const State& state : {State{"no session", 5}, State{"runs without a sender", 1},
                             State{"held by its watchdog", 2}, State{"alarm", 4}}) {
    RingShop shop;
    const std::string name = state.name;
    if (name == "alarm") {
      EXPECT_FALSE(send_over(alarm, shop.link, shop.wire, shop.wire, {}, {}));
    } else if (name != "no session") {
      shop.wire.die_at = 60;
      EXPECT_FALSE(send_over(path, shop.link, shop.wire, shop.wire, {}, {}));
      shop.wire.die_at = ~0ULL;
      if (name == "held by its watchdog") shop.wait(5.0);
    }
    ASSERT_EQ(shop.state(), state.shown) << name;
    if (name == "held by its watchdog") {
      EXPECT_NE(shop.wire.controller.motion().accessories().spindle, 0.0);
    }
    const auto refused = send_over(small, shop.link, shop.wire, shop.wire, {}, {});
    EXPECT_EQ(refused.has_value(), name == "no session") << name;
    const auto reset = reset_machine(shop.link, shop.wire, shop.wire);
    ASSERT_TRUE(reset) << name << ": " << reset.error().message;
    EXPECT_EQ(shop.state(), 5) << name << ": " << *reset;
    EXPECT_NE(reset->find("spindle and coolant are off"), std::string::npos) << *reset;
    EXPECT_EQ(shop.wire.controller.motion().accessories().spindle, 0.0) << name;
    // What an alarm may have cost.
    EXPECT_EQ(reset->find("the position is kept") != std::string::npos,
              name != "no session" && name != "alarm")
        << *reset;
    EXPECT_TRUE(shop.wire.controller.motion().idle()) << name;
    const auto report = send_over(small, shop.link, shop.wire, shop.wire, {}, {});
    EXPECT_TRUE(report) << name << ": " << report.error().message;
  }
}

TEST(MachineOrders, TheRingsMailboxOffersUnlockAndAFeedOverride) {
  const Folder folder("reset");
  const std::string alarm = folder.write("alarm.nc", "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X9999 F100\nM2\n");
  RingShop shop;
  MachineProfile profile;
  profile.model = wide_machine();
  const MachineBench bench{profile, shop.link, shop.wire, shop.wire};
  const auto say = [&](const char* name, const std::vector<std::string>& words = {}) {
    const auto answer = perform_order(bench, name, words);
    return answer ? answer->text : "refused: " + answer.error().message;
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != text.npos; };
  EXPECT_TRUE(has(say("unlock"), "no alarm"));
  EXPECT_FALSE(send_over(alarm, shop.link, shop.wire, shop.wire, {}, {}));
  ASSERT_EQ(shop.state(), 4);
  EXPECT_TRUE(has(say("status"), "Alarm, session")) << say("status");
  EXPECT_TRUE(has(say("status"), "alarm 2")) << say("status");
  EXPECT_TRUE(has(say("status"), "program  X0 Y0 Z0 A0 C0")) << say("status");
  EXPECT_TRUE(has(say("unlock"), "alarm 2 is cleared"));
  EXPECT_EQ(shop.state(), 0);
  EXPECT_TRUE(has(say("override", {"feed", "55"}), "feed override 55 %"));
  EXPECT_EQ(shop.wire.controller.motion().feed_override(), 55);
  EXPECT_TRUE(has(say("status"), "override feed 55 %"));
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"feed", "9"}, {"feed", "201"}, {"rapid", "50"}, {"feed"}})
    EXPECT_TRUE(has(say("override", words), "feed override only")) << words[0];
  EXPECT_EQ(shop.wire.controller.motion().feed_override(), 55);
  for (const char* name : {"jog", "home", "offsets", "probe", "settings", "console", "tool"})
    EXPECT_TRUE(
        has(say(name, {"X1"}), "do it at the control; status, unlock, override, and `tiltfeed reset`"))
        << name;
}

TEST(MachineReset, RepRapEndsWithSpindleAndCoolantOff) {
  const Folder folder("reset");
  sim::RepRapController controller(wide_machine(), {}, {}, [](const sim::TraceRow&) {});
  VirtualLine<sim::RepRapController> line(controller, {}, 10.0 / 115200);
  std::string in;
  static_cast<void>(line.exchange("G90\nM3 S8000\nM8\nG1 X1 F600\n", std::chrono::seconds(1), in));
  const LinkSpec link = *parse_link("reprap:/dev/null@115200");
  const auto reset = reset_machine(link, line, line);
  ASSERT_TRUE(reset) << reset.error().message;
  EXPECT_EQ(controller.motion().accessories().spindle, 0.0);
  EXPECT_TRUE(send_over(folder.write("small.nc", kSmall), link, line, line, {}, {}));
}

/// Takes every byte, and nothing ever comes.
struct SilentWire : Link, Clock {
  Time time{};
  Time now() override { return time; }
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string&) override {
    time += std::max<Time>(wait, std::chrono::milliseconds(1));
    return out.size();
  }
};

TEST(MachineReset, OfAControllerThatNeverAnswersIsNotDone) {
  SilentWire wire;
  const auto reset = reset_machine(*parse_link("grbl:/dev/null@115200"), wire, wire);
  ASSERT_FALSE(reset);
  EXPECT_NE(reset.error().message.find("has not answered"), std::string::npos) << reset.error().message;
  EXPECT_EQ(reset.error().message.find("was reset"), std::string::npos) << reset.error().message;
}

TEST(MachineReset, SaysFirstWhatItWillDo) {
  for (const char* link : {"grbl:/dev/x", "reprap:/dev/x", "dnc:/dev/x", "modbus-tcp:h:1", "drive-tcp:h:1"})
    EXPECT_GT(reset_preview(*parse_link(link)).size(), 40u) << link;
}

// ---- where it stands -----------------------------------------------------------------------------------

TEST(ReadPlace, IsInTheProgramsCoordinates) {
  MachineModel machine = wide_machine();
  GrblShop shop;
  shop.say("G21 G90 G94\nG0 X1.5 Y-2 Z30 A12.5 C-400\n", 3.0);
  const auto at = read_place(shop.link, machine, shop.line, shop.line);
  ASSERT_TRUE(at) << at.error().message;
  ASSERT_TRUE(*at);
  EXPECT_EQ(**at, (Joints{1.5, -2, 30, 12.5, -400}));
  RingShop ring;
  const auto there = read_place(ring.link, machine, ring.wire, ring.wire);
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ(there->value(), Joints{});
}

TEST(WatchdogHold, IsShownAsSuchAndCanBeResumed) {
  const Folder folder("reset");
  std::string program = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 F600\n";
  for (int i = 1; i <= 60; ++i) program += "G1 X" + std::to_string(i % 2 * 30) + "\n";
  const std::string path = folder.write("part.nc", program + "M2\n");
  for (const bool late : {true, false}) {
    RingShop shop;
    CommandQueue orders;
    StreamHooks hooks;
    hooks.commands = &orders;
    std::vector<std::string> held;
    bool paused = false;
    hooks.progress = [&](const SendState& state) {
      if (state.phase == Phase::kHold && !state.held.empty()) {
        if (held.empty() || held.back() != state.held) held.push_back(state.held);
        orders.push({Order::kResume});
      }
      if ((state.phase == Phase::kRun || state.phase == Phase::kDrain) && shop.executed > 3 && !paused) {
        paused = true;
        if (late)
          shop.wait(1.5);  // this host is late
        else
          orders.push({Order::kHold});
      }
      return true;
    };
    const auto report = send_over(path, shop.link, shop.wire, shop.wire, {}, hooks);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(paused);
    ASSERT_EQ(held.size(), 1u) << late;
    EXPECT_NE(held.front().find(late ? "watchdog" : "on request"), std::string::npos) << held.front();
  }
}

TEST(RingPlace, TheEndIsProvedByTheReportedPosition) {
  // A machine whose travel ends where the program still goes on would be in alarm; one whose axes slip is
  // not.
  const Folder folder("reset");
  RingShop shop;
  const std::string path = folder.write("small.nc", kSmall);
  LinkSpec scaled = shop.link;
  scaled.profile.ring.linear_exponent = 4;
  EXPECT_TRUE(send_over(path, scaled, shop.wire, shop.wire, {}, {}));
  // Its blocks are read ten times smaller than they are told back: no counter shows that, the place does.
  class Slipping : public Link {
   public:
    explicit Slipping(Link& wire) : wire_(wire) {}
    Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
      const std::size_t before = in.size();
      const auto taken = wire_.exchange(out, wait, in);
      if (out.empty() || unpack_request(out).read_address != RingMap{}.positions) return taken;
      ModbusReply reply = unpack_reply(std::string_view(in).substr(before));
      if (!reply.words.empty()) reply.words[1] = static_cast<std::uint16_t>(reply.words[1] + 5000);
      in = in.substr(0, before) + pack_reply(reply);
      return taken;
    }

   private:
    Link& wire_;
  } slipping(shop.wire);
  const auto report = send_over(path, shop.link, slipping, shop.wire, {}, {});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("not at the program's end"), std::string::npos)
      << report.error().message;
}

}  // namespace
}  // namespace tiltfeed
