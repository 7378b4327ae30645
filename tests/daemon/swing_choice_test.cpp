// Swings at the retract: where the axes stop on their way, and where the stretch behind begins on the tilt's
// other side or a turn further. Places of the tool by the simulated machine's own chain.

#include "daemon/plan/swing_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "config/machine_profile.h"
#include "sim/motion/forward.h"

namespace tiltfeed::daemon {
namespace {

const std::vector<std::string> kSwingMachines{"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc",
                                              "mill-4x-table-a", "mill-4x-head-b"};

struct SwingDice {
  std::mt19937 random;
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  Joints place(const MachineModel& machine) {
    Joints at{(*this)(-50, 50), (*this)(-50, 50), (*this)(-50, 0), machine.tilt.zero + (*this)(-40, 40),
              (*this)(-100, 100)};
    if (!machine.tilt.present) at.a = 0.0;
    if (!machine.rotary.present) at.c = 0.0;
    return at;
  }
};

MachineModel model_of(const std::string& name) {
  return config::load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml")->model;
}

/// The axes that move from p to q: of "XYZAC".
std::string moved(const Joints& p, const Joints& q) {
  std::string axes;
  if (p.x != q.x || p.y != q.y) axes += "X";
  if (p.z != q.z) axes += "Z";
  if (p.a != q.a) axes += "A";
  if (p.c != q.c) axes += "C";
  return axes;
}

TEST(SwingChoice, TheAxesGoInTheOrderThatIsSaid) {
  // By order of the rotaries, X and Y behind and before.
  const std::vector<std::vector<std::string>> orders{
      {"AC", "X"}, {"A", "C", "X"}, {"C", "A", "X"}, {"A", "C", "A", "X"},
      {"X", "AC"}, {"X", "A", "C"}, {"X", "C", "A"}, {"A", "X", "C", "A"}};
  SwingDice dice{std::mt19937(3)};
  const MachineModel machine = model_of("generic-ac");
  for (int run = 0; run < 100; ++run) {
    const Joints from = dice.place(machine);
    Joints to = dice.place(machine);
    to.z = from.z;
    for (std::size_t i = 0; i < orders.size(); ++i) {
      const SwingWay way = kSwingChoices[i].way;
      std::vector<std::string> steps;
      Joints at = from;
      for (const Joints& place : swing_places(machine, from, to, way)) {
        steps.push_back(moved(at, place));
        at = place;
      }
      EXPECT_EQ(steps, orders[i]) << i;
      EXPECT_EQ(at, to) << i;
      if (way.order == SwingOrder::kOverHome) {
        EXPECT_EQ(swing_places(machine, from, to, way).front().a, machine.tilt.zero);
      }
    }
  }
}

TEST(SwingChoice, TheToolStandsAsPlannedOnTheOtherSideAndATurnFurther) {
  SwingDice dice{std::mt19937(5)};
  int other_sides = 0, other_ways = 0;
  for (const std::string& name : kSwingMachines) {
    const MachineModel machine = model_of(name);
    tiltfeed::Setup setup;
    setup.part_zero = {3, -4, 20}, setup.tool_length = 60;
    setup.fixture = rotation_about({0, 0, 1}, 0.3);
    for (int run = 0; run < 200; ++run) {
      const Joints from = dice.place(machine), usual = dice.place(machine);
      const Pose planned = sim::forward_by_frames(machine, setup, usual);
      for (const SwingChoice& choice : kSwingChoices) {
        const auto to = swung(machine, setup, from, usual, choice);
        if (!to) continue;
        const Pose pose = sim::forward_by_frames(machine, setup, *to);
        EXPECT_LT(distance(pose.tip, planned.tip), 1e-6) << name;
        EXPECT_LT(length(pose.axis - planned.axis), 1e-9) << name;
        EXPECT_FALSE(broken_limit(machine, *to)) << name;
        if (choice.other_side) {
          EXPECT_LT((to->a - machine.tilt.zero) * (usual.a - machine.tilt.zero), 0.0) << name;
          ++other_sides;
        }
        if (!choice.other_way) continue;
        ++other_ways;
        SwingChoice same = choice;
        same.other_way = false;
        const auto short_way = swung(machine, setup, from, usual, same);
        if (!short_way) continue;  // beyond a limit
        EXPECT_LT((to->c - from.c) * (short_way->c - from.c), 0.0) << name;
        EXPECT_NEAR(std::abs(to->c - short_way->c), 360.0, 1e-9) << name;
      }
    }
  }
  EXPECT_GT(other_sides, 1000);
  EXPECT_GT(other_ways, 1000);
}

TEST(SwingChoice, AWayIsAnotherOnlyWhereTheAxesStopElsewhere) {
  const MachineModel machine = model_of("generic-ac");
  const tiltfeed::Setup setup;
  const auto count = [&](const Joints& from, const Joints& to) {
    std::vector<std::vector<Joints>> ways;
    for (std::size_t i = 0; i < kSwingChoices.size(); ++i) {
      if (i > 0 && !differs(machine, setup, from, to, i)) continue;
      const auto at = swung(machine, setup, from, to, kSwingChoices[i]);
      EXPECT_TRUE(at);
      if (!at) continue;
      const auto way = swing_places(machine, from, *at, kSwingChoices[i].way);
      EXPECT_EQ(std::count(ways.begin(), ways.end(), way), 0) << i;
      ways.push_back(way);
    }
    return ways.size();
  };
  const Joints from{10, 20, 0, 30, 40};
  EXPECT_EQ(count(from, {50, 60, 0, -20, 100}), kSwingChoices.size());
  // The rotary stands: in the planned side's orders it is before or behind X and Y, or over home.
  EXPECT_LT(count(from, {50, 60, 0, -20, 40}), kSwingChoices.size());
  // Nothing turns, and the tilt is at home: there is one way, across.
  Joints home = from;
  home.a = 0.0;
  EXPECT_EQ(count(home, {50, 60, 0, 0, 40}), 1u);
}

TEST(SwingChoice, NoAxisGoesBeyondItsTravel) {
  MachineModel machine = model_of("generic-ac");
  const tiltfeed::Setup setup;
  const Joints from{0, 0, 0, 20, 0}, usual{0, 0, 0, 30, 40};
  const SwingChoice side{{}, true, false}, round{{}, false, true},
      home{{SwingOrder::kOverHome}, false, false};
  for (const SwingChoice& choice : {side, round, home})
    EXPECT_TRUE(swung(machine, setup, from, usual, choice));
  machine.tilt.min = 10, machine.rotary.min = -100, machine.rotary.max = 300;
  for (const SwingChoice& choice : {side, round, home})
    EXPECT_FALSE(swung(machine, setup, from, usual, choice));
  EXPECT_TRUE(swung(machine, setup, from, usual, {}));
  machine = model_of("generic-ac");
  machine.rotary.word = RotaryWord::kShortest;
  EXPECT_FALSE(swung(machine, setup, from, usual, round)) << "such words count no turns";
}

}  // namespace
}  // namespace tiltfeed::daemon
