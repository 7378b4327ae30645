// Machines with hidden errors are measured by a ball; the profile that comes of it keeps the tip still, by
// the simulated machine's own chain of frames.

#include "daemon/measure/pivot_fit.h"

#include <gtest/gtest.h>

#include "config/machine_profile.h"
#include "daemon/measure/tip_spread.h"
#include "tests/daemon/hidden_machine.h"

namespace tiltfeed::daemon {
namespace {

MachineModel shipped(const std::string& name) {
  const auto profile = config::load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml");
  EXPECT_TRUE(profile) << profile.error().message;
  return profile ? profile->model : MachineModel{};
}

std::vector<BallPlace> grid(std::vector<double> tilts, std::vector<double> turns,
                            double tool_length = 120.0) {
  std::vector<BallPlace> all;
  for (const double a : tilts)
    for (const double c : turns) all.push_back({a, c, tool_length});
  return all;
}
std::vector<double> turns(int count) {
  std::vector<double> all;
  for (int i = 0; i < count; ++i) all.push_back(360.0 * i / count);
  return all;
}

// The printed places of a table-head machine, worked by hand and by another program.
TEST(BallMachine, IsTheFormulaOfATableUnderAHead) {
  BallMachine m;
  m.machine = shipped("generic-ac");
  m.machine.rotary.direction = normalized({.001, -.0015, 1});
  m.machine.tilt.direction = normalized({1, .0012, -.0008});
  m.machine.pivot_to_gauge = {.1, -.22, -270.28};
  // There the gauge line's home does not count: the readings are the pivot's.
  m.machine.table_centre = {.25 - .1, -.18 + .22, .3 + 270.28};
  m.ball = {120.4, 59.1, 80.7};
  for (const auto& [a, c, expected] : {std::tuple{0.0, 0.0, Vec3{120.55, 59.14, 351.28}},
                                       {0.0, 120.0, Vec3{-8.642052, -133.891047, 351.119645}},
                                       {-60.0, 90.0, Vec3{59.06267, 113.558642, 215.741285}}})
    EXPECT_LT(length(reading_at(m, {a, c, 0.0}) - expected), 2e-6) << a << " " << c;
}

TEST(BallMachine, IsTheSimulatedMachineOfEveryStructure) {
  std::mt19937 random(7);
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc", "dmu-nutating-bc",
                           "mill-4x-table-a", "mill-4x-head-b"}) {
    BallMachine m{hidden(shipped(name), random, 5.0, 3.0), {90, -40, 70}, 0.0};
    const bool head = m.machine.structure == Structure::kHeadHead;
    const Vec3 target = head ? m.ball - from_origin(m.machine.table_centre) : m.ball;
    for (const BallPlace& at : grid({0, 20, -35}, {0, 100, 250})) {
      BallPlace real = at;
      if (!m.machine.tilt.present) real.tilt = 0;
      if (!m.machine.rotary.present) real.rotary = 0;
      EXPECT_LT(length(reading_at(m, real) - axes_to(m.machine, real, target)), 1e-9) << name;
    }
  }
}

// Without noise what was hidden is found, whatever words the machine has for it.
TEST(PivotFit, FindsWhatIsHiddenInEveryStructure) {
  std::mt19937 random(11);
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc", "dmu-nutating-bc",
                           "mill-4x-table-a", "mill-4x-head-b"}) {
    SCOPED_TRACE(name);
    const MachineModel before = shipped(name), real = hidden(before, random, 0.3, 0.1);
    std::vector<BallPlace> places =
        before.rotary.present ? grid({-50, 0, 25, 50}, {-80, 0, 45, 80}) : grid({-50, 0, 25, 50, 80}, {0});
    if (!before.tilt.present)
      for (BallPlace& p : places) p.tilt = 0;
    const auto fit = fit_pivots(before, measured(real, {90, -40, 70}, places, 0.0, false, random));
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_EQ(fit->rank, fit->full_rank);
    EXPECT_TRUE(fit->untold.empty());
    const MachineModel found = settled(fit->found, before, fit->spindle, fit->tool_length);
    std::mt19937 poses(3);
    EXPECT_GT(worst_tip(real, before, 120.0, 300, poses), 0.1);
    EXPECT_LT(worst_tip(real, found, 120.0, 300, poses), 1e-6);
  }
}

// Hidden errors of 0.3 mm and 0.1 degrees, 0.002 mm of noise a touch, 40 places: at most 0.006 mm are left
// anywhere, and no more than is foretold.
TEST(PivotFit, KeepsTheTipStillWithNoisyTouches) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc"})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(name + std::string(" seed ") + std::to_string(seed));
      std::mt19937 random(seed);
      const MachineModel before = shipped(name), real = hidden(before, random, 0.3, 0.1);
      std::vector<double> tilts;
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
        tilts.push_back(std::lerp(std::max(-90.0, before.tilt.min), std::min(90.0, before.tilt.max), share));
      const auto readings = measured(real, {150, 100, 150}, grid(tilts, turns(8)), 0.002, true, random);
      const auto fit = fit_pivots(before, readings);
      ASSERT_TRUE(fit) << fit.error().message;
      EXPECT_NEAR(fit->noise, 0.002, 0.0004);
      EXPECT_LT(fit->condition, 12.0);
      EXPECT_NEAR(fit->found.radius, 12.5, 0.002);
      const MachineModel found = settled(fit->found, before, fit->spindle, fit->tool_length);
      const double was = worst_tip(real, before, 120.0, 2000, random);
      const double now = worst_tip(real, found, 120.0, 2000, random);
      EXPECT_GT(was, 0.3);
      EXPECT_LT(now, 0.006);
      const double foretold = tip_spread(*fit, before, fit->known);
      EXPECT_LT(now, 4.0 * foretold);
      EXPECT_GT(now, 0.2 * foretold);
    }
}

// The spread that is told is the one that repeated measurements have.
TEST(PivotFit, TellsItsOwnSpread) {
  std::mt19937 random(5);
  const MachineModel before = shipped("generic-ac"), real = hidden(before, random, 0.3, 0.1);
  double sum = 0.0, square = 0.0, told = 0.0;
  constexpr int kTimes = 50;
  for (int i = 0; i < kTimes; ++i) {
    const auto fit =
        fit_pivots(before, measured(real, {120, 60, 80}, grid({-60, 0, 60}, turns(4)), 0.002, false, random));
    ASSERT_TRUE(fit) << fit.error().message;
    for (const ValueSpread& one : spreads(*fit, before)) {
      if (one.value.key != "pivot_to_gauge_mm") continue;
      sum += one.value.parts[2], square += one.value.parts[2] * one.value.parts[2];
      told += one.spread[2] / kTimes;
    }
  }
  const double spread = std::sqrt(square / kTimes - sum / kTimes * sum / kTimes);
  EXPECT_GT(told, 0.0003);
  EXPECT_NEAR(spread / told, 1.0, 0.3);
}

// Two lengths of the stylus tell the spindle, and so the tilt's zero: tools of any length are right then.
TEST(PivotFit, TellsTheSpindleByTwoLengths) {
  std::mt19937 random(9);
  const MachineModel before = shipped("generic-ac");
  MachineModel real = hidden(before, random, 0.3, 0.1);
  real.spindle = normalized({0.0012, -0.0009, 1});
  std::vector<BallPlace> places = grid({-60, 0, 60}, turns(4));
  for (const BallPlace& at : grid({-60, 60}, turns(3), 220.0)) places.push_back(at);
  const auto fit = fit_pivots(before, measured(real, {120, 60, 80}, places, 0.0, false, random));
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_TRUE(fit->spindle);
  const MachineModel found = settled(fit->found, before, true, fit->tool_length);
  EXPECT_LT(worst_tip(real, found, 60.0, 300, random), 1e-6);
  EXPECT_LT(worst_tip(real, found, 300.0, 300, random), 1e-6);
  // The same machine by one length: right for that length only.
  const auto one =
      fit_pivots(before, measured(real, {120, 60, 80}, grid({-60, 0, 60}, turns(4)), 0.0, false, random));
  ASSERT_TRUE(one);
  EXPECT_FALSE(one->spindle);
  const MachineModel leaning = settled(one->found, before, false, one->tool_length);
  EXPECT_LT(worst_tip(real, leaning, 120.0, 300, random), 1e-6);
  EXPECT_GT(worst_tip(real, leaning, 300.0, 300, random), 0.05);
  // It is taken to lean so that the tool still stands along the rotary's axis.
  EXPECT_NEAR(angle_between(leaning.tilt.direction, leaning.spindle),
              angle_between(leaning.tilt.direction, leaning.rotary.direction), 1e-12);
}

TEST(PivotFit, SeesASignThatIsWrong) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc"})
    for (const int turned : {1, 2, 3}) {
      SCOPED_TRACE(name + std::string(" ") + std::to_string(turned));
      std::mt19937 random(3);
      const MachineModel before = shipped(name);
      MachineModel real = hidden(before, random, 0.3, 0.1);
      if (turned & 1) real.tilt.sign = -real.tilt.sign;
      if (turned & 2) real.rotary.sign = -real.rotary.sign;
      const auto fit = fit_pivots(
          before,
          measured(real, {90, -40, 70}, grid({-50, 0, 25, 50}, {-80, 0, 45, 80}), 0.002, false, random));
      ASSERT_TRUE(fit) << fit.error().message;
      const MachineModel found = settled(fit->found, before, fit->spindle, fit->tool_length);
      EXPECT_EQ(found.tilt.sign, real.tilt.sign);
      EXPECT_EQ(found.rotary.sign, real.rotary.sign);
      EXPECT_LT(worst_tip(real, found, 120.0, 300, random), 0.03);
    }
}

// Ranks and conditions as another program found them for a table under a head.
TEST(PivotFit, TellsWhatThePlacesCannot) {
  std::mt19937 random(1);
  const MachineModel before = shipped("generic-ac"), real = hidden(before, random, 0.3, 0.1);
  const auto fit = [&](const std::vector<BallPlace>& places) {
    return fit_pivots(before, measured(real, {120, 60, 80}, places, 0.002, false, random)).value();
  };
  const PivotFit turning = fit(grid({0}, turns(8)));
  EXPECT_EQ(turning.rank, 7);
  EXPECT_EQ(turning.full_rank, 11);
  const auto untold = [](const PivotFit& one, const char* key) {
    return std::count(one.untold.begin(), one.untold.end(), key) > 0;
  };
  EXPECT_TRUE(untold(turning, "tilt.direction"));
  EXPECT_TRUE(untold(turning, "pivot_to_gauge_mm"));
  EXPECT_FALSE(untold(turning, "rotary.direction"));
  const PivotFit tilting = fit(grid({-60, -30, 0, 30, 60}, {0}));
  EXPECT_EQ(tilting.rank, 7);
  EXPECT_TRUE(untold(tilting, "rotary.direction"));
  EXPECT_FALSE(untold(tilting, "tilt.direction"));
  EXPECT_NEAR(fit(grid({0, 20, 40}, turns(4))).condition, 70.0, 15.0);
  EXPECT_NEAR(fit(grid({-60, 0, 60}, turns(4))).condition, 8.0, 1.0);
  // The places that are proposed make all of it seen.
  std::vector<BallPlace> more = grid({0}, turns(8));
  for (const NextPlace& one : next_places(turning, before, 0.002, 0.004, 40)) more.push_back(one.at);
  EXPECT_LT(more.size(), 40u);
  const PivotFit whole = fit(more);
  EXPECT_TRUE(whole.untold.empty());
  EXPECT_LT(whole.condition, 12.0);
  EXPECT_LT(tip_spread(whole, before, whole.known), 0.006);
}

TEST(PivotFit, NamesThePlaceThatIsWrong) {
  std::mt19937 random(2);
  const MachineModel before = shipped("generic-ac"), real = hidden(before, random, 0.3, 0.1);
  auto readings = measured(real, {120, 60, 80}, grid({-60, 0, 60}, turns(4)), 0.002, false, random);
  readings.all[6].axes.y += 0.05;
  const auto fit = fit_pivots(before, readings);
  ASSERT_FALSE(fit);
  EXPECT_NE(fit.error().message.find("place 7 (line 8)"), std::string::npos) << fit.error().message;
  const auto few =
      fit_pivots(before, measured(real, {120, 60, 80}, grid({0, 60, 90}, {0}), 0.002, false, random));
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message.find("3 places give 9 readings"), std::string::npos) << few.error().message;
  auto flat = measured(real, {120, 60, 80}, grid({-60, 0, 60}, turns(4)), 0.002, true, random);
  std::erase_if(flat.all, [&](const BallReading& one) {
    return one.place == 3 && one.axes.z > axes_to(real, one.at, {120, 60, 80}).z + 1.0;
  });
  const auto plane = fit_pivots(before, flat);
  ASSERT_FALSE(plane);
  EXPECT_NE(plane.error().message.find("place 4 lie in one plane"), std::string::npos)
      << plane.error().message;
}

}  // namespace
}  // namespace tiltfeed::daemon
