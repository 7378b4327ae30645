// Failure 20 of the field over serial links: the service dies in mid-program, and what systemd runs after it
// stops the simulated machine over the same wire, also where the wire spoils what is said.

#include "daemon/service/safe_stop.h"
#include "daemon/machine/stop_machine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/peers/line_run.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

/// The wire of a process that is killed at `dies_at`, s: nothing passes from then on.
class MortalLink : public Link {
 public:
  MortalLink(Link& wire, const double& time, double dies_at) : wire_(wire), time_(time), dies_at_(dies_at) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (time_ >= dies_at_) return fail(Code::kLink, "killed");
    return wire_.exchange(out, wait, in);
  }

 private:
  Link& wire_;
  const double& time_;
  double dies_at_;
};

/// A controller on a line, fed by a sender that dies, then stopped.
template <class Controller, class Options>
struct Shop {
  explicit Shop(const std::string& link_text, const MachineModel& machine = wide_machine(),
                const Options& firmware = {})
      : link(*parse_link(link_text)),
        controller(machine, {}, firmware,
                   [this](const sim::TraceRow& row) { executed.push_back(row.command); }),
        line(controller, {}, 10.0 / link.baud) {}

  void feed_until_killed(const std::string& program, double dies_at) {
    const std::string path = "/tmp/tiltfeed_safe_stop_" + std::to_string(::getpid()) + ".nc";
    std::ofstream(path) << program;
    MortalLink wire(line, line.time, dies_at);
    const auto report = send_over(path, link, wire, line, {}, {});
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find("killed"), std::string::npos) << report.error().message;
    std::filesystem::remove(path);
  }
  /// What goes wrong on the wire from now on.
  void spoil(const std::string& faults) {
    line.line = sim::FaultyLine(*sim::parse_fault_script(faults, "faults"));
  }
  Result<std::string> stop() {
    const double began = line.time;
    const Result<std::string> stopped = stop_machine(link, line, line);
    seconds = line.time - began;
    return stopped;
  }
  void wait(double time) {
    std::string in;
    for (const double end = line.time + time; line.time < end;)
      static_cast<void>(line.exchange({}, std::chrono::milliseconds(100), in));
  }
  const sim::Accessories& accessories() const { return controller.motion().accessories(); }

  LinkSpec link;
  std::vector<sim::Block> executed;
  Controller controller;
  VirtualLine<Controller> line;
  double seconds = 0.0;
};
using GrblShop = Shop<sim::GrblController, sim::GrblOptions>;
using RepRapShop = Shop<sim::RepRapController, sim::RepRapOptions>;

constexpr const char* kGrbl = "grbl:/dev/null@115200";
constexpr const char* kRepRap = "reprap:/dev/null@115200";

/// Feeds of 0.2 s with spindle and coolant on.
std::string cutting() {
  std::string text = short_blocks(600, 0.2);
  return text.insert(text.find("G93"), "M8\n");
}

bool on_the_way(const Joints& at, const Joints& from, const Joints& to) {
  const double a[] = {at.x, at.y, at.z, at.a, at.c}, b[] = {from.x, from.y, from.z, from.a, from.c},
               c[] = {to.x, to.y, to.z, to.a, to.c};
  const double f = (a[0] - b[0]) / (c[0] - b[0]);
  for (int i = 1; i < 5; ++i)
    if (std::abs(b[i] + f * (c[i] - b[i]) - a[i]) > 1e-9) return false;
  return f >= 0.0 && f <= 1.0;
}

TEST(SafeStop, F20_GrblIsHeldAndItsSpindleOffWithThePositionKept) {
  GrblShop shop(kGrbl);
  shop.feed_until_killed(cutting(), 9.0);
  EXPECT_EQ(shop.accessories().spindle, 8000.0);
  EXPECT_TRUE(shop.accessories().flood);
  EXPECT_FALSE(shop.controller.motion().idle()) << "it would cut on";
  const Result<std::string> stopped = shop.stop();
  ASSERT_TRUE(stopped) << stopped.error().message;
  EXPECT_NE(stopped->find("position is kept"), std::string::npos);
  EXPECT_LT(shop.seconds, 1.0);
  EXPECT_EQ(shop.controller.alarm(), 0) << "a reset in motion loses the position";
  EXPECT_EQ(shop.accessories().spindle, 0.0);
  EXPECT_FALSE(shop.accessories().flood);
  // Where it stands is on the way from the last block that was executed to the next one of the program.
  const std::size_t done = shop.executed.size();
  const Joints at = shop.controller.motion().position();
  EXPECT_TRUE(shop.controller.motion().idle());
  const sim::Block& last = shop.executed.back();
  const Joints next{last.target.x + 0.01, last.target.y + 0.02, last.target.z - 0.001, last.target.a + 0.001,
                    last.target.c + 0.05};
  EXPECT_TRUE(on_the_way(at, last.target, next)) << at.x << " after " << last.target.x;
  // Nothing is left that a cycle start could set in motion.
  shop.controller.receive("~");
  shop.wait(5.0);
  EXPECT_EQ(shop.executed.size(), done);
  EXPECT_EQ(shop.controller.motion().position().x, at.x);
}

TEST(SafeStop, GrblIsNotResetBeforeItStands) {
  MachineModel heavy = wide_machine();
  heavy.x.acceleration = 500.0;  // a second from 500 mm/s
  for (const double speed : {3000.0, 30000.0}) {
    GrblShop shop(kGrbl, heavy);
    shop.feed_until_killed(
        "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nM3 S100\nG1 X900 F" + std::to_string(speed) + "\nM2\n", 2.0);
    const double running = shop.controller.motion().speed();
    ASSERT_GT(running, 0.7 * speed);
    const Result<std::string> stopped = shop.stop();
    ASSERT_TRUE(stopped) << stopped.error().message;
    EXPECT_EQ(shop.controller.alarm(), 0);
    EXPECT_GE(shop.seconds, running / 60.0 / heavy.x.acceleration);
    EXPECT_EQ(shop.accessories().spindle, 0.0);
  }
}

TEST(SafeStop, F20_GrblOverALineThatLosesAndSpoilsBytes) {
  for (int seed = 1; seed <= 40; ++seed) {
    GrblShop shop(kGrbl);
    shop.feed_until_killed(cutting(), 9.0);
    shop.spoil("seed " + std::to_string(seed) + "\ndrop to-machine p=0.2\ncorrupt to-host p=0.02\n");
    const Result<std::string> stopped = shop.stop();
    EXPECT_EQ(shop.accessories().spindle, 0.0) << "seed " << seed;
    EXPECT_TRUE(shop.controller.motion().idle()) << "seed " << seed;
    EXPECT_EQ(shop.controller.alarm(), 0) << "seed " << seed;
    EXPECT_LT(Time(std::chrono::duration_cast<Time>(std::chrono::duration<double>(shop.seconds))),
              kSafeStopLimit);
    EXPECT_TRUE(stopped || stopped.error().message.find("look at the machine") != std::string::npos);
  }
}

TEST(SafeStop, F20_GrblThatIsDeafOrSilentIsSaid) {
  GrblShop mute(kGrbl);
  mute.feed_until_killed(cutting(), 9.0);
  mute.spoil("drop to-host p=1\n");
  const Result<std::string> unseen = mute.stop();
  ASSERT_FALSE(unseen);
  EXPECT_NE(unseen.error().message.find("has not answered"), std::string::npos);
  // Said blindly, but in the right order: held first, so that the reset kept the position.
  EXPECT_EQ(mute.accessories().spindle, 0.0);
  EXPECT_EQ(mute.controller.alarm(), 0);

  GrblShop deaf(kGrbl);
  deaf.feed_until_killed(cutting(), 9.0);
  deaf.spoil("drop to-machine p=1\n");
  EXPECT_FALSE(deaf.stop());
  EXPECT_LT(deaf.seconds, 20.0);
}

TEST(SafeStop, GrblInAlarmIsSaidToHaveLostItsPosition) {
  GrblShop shop(kGrbl);
  shop.feed_until_killed(cutting(), 9.0);
  shop.controller.raise_alarm(1);
  const Result<std::string> stopped = shop.stop();
  ASSERT_FALSE(stopped);
  EXPECT_NE(stopped.error().message.find("home it"), std::string::npos);
  EXPECT_EQ(shop.accessories().spindle, 0.0);
}

TEST(SafeStop, F20_RepRapCutsWhatItHasThenItsSpindleIsOff) {
  RepRapShop shop(kRepRap);
  shop.feed_until_killed(cutting(), 9.0);
  const std::size_t before = shop.executed.size();
  const Result<std::string> stopped = shop.stop();
  ASSERT_TRUE(stopped) << stopped.error().message;
  EXPECT_EQ(shop.accessories().spindle, 0.0);
  EXPECT_FALSE(shop.accessories().flood);
  EXPECT_TRUE(shop.controller.motion().idle());
  // The planner's 16 blocks and the queue's 4 lines, then M5 and M9: in order, none left out.
  ASSERT_GE(shop.executed.size(), 2u);
  EXPECT_LE(shop.executed.size() - before, 16u + 4u + 2u);
  const std::size_t feeds = shop.executed.size() - 2;
  EXPECT_EQ(shop.executed[feeds].m_code, 5);
  EXPECT_EQ(shop.executed[feeds + 1].m_code, 9);
  for (std::size_t i = 4; i < feeds; ++i)
    EXPECT_NEAR(shop.executed[i].target.x - shop.executed[i - 1].target.x, 0.01, 1e-9);
}

TEST(SafeStop, F20_RepRapOverABadLineAndWithLongBlocks) {
  for (int seed = 1; seed <= 20; ++seed) {
    RepRapShop shop(kRepRap);
    shop.feed_until_killed(cutting(), 9.0);
    shop.spoil("seed " + std::to_string(seed) + "\ndrop to-machine p=0.02\ncorrupt to-machine p=0.02\n");
    const Result<std::string> stopped = shop.stop();
    shop.wait(10.0);
    EXPECT_TRUE(!stopped || shop.accessories().spindle == 0.0) << "seed " << seed;
  }
  // Blocks so long that nothing can be confirmed in time: M5 waits behind them in the firmware.
  RepRapShop shop(kRepRap);
  shop.feed_until_killed(short_blocks(600, 10.0), 9.0);
  const Result<std::string> stopped = shop.stop();
  ASSERT_FALSE(stopped);
  EXPECT_LT(shop.seconds, 21.0);
  EXPECT_NE(stopped.error().message.find("look at the machine"), std::string::npos);
  shop.wait(400.0);
  EXPECT_EQ(shop.accessories().spindle, 0.0);
}

TEST(SafeStop, OnlyAnOrderlyEndNeedsNoStop) {
  EXPECT_TRUE(in_order({"success", "exited", "0"}));
  // systemd counts these signals as a success.
  for (const char* signal : {"TERM", "HUP", "INT", "PIPE"})
    EXPECT_FALSE(in_order({"success", "killed", signal}));
  EXPECT_FALSE(in_order({"signal", "killed", "KILL"}));
  EXPECT_FALSE(in_order({"watchdog", "killed", "ABRT"}));
  EXPECT_FALSE(in_order({"timeout", "killed", "KILL"}));
  EXPECT_FALSE(in_order({"exit-code", "exited", "1"}));
  EXPECT_FALSE(in_order({"oom-kill", "killed", "KILL"}));
  EXPECT_FALSE(in_order({}));
}

}  // namespace
}  // namespace tiltfeed
