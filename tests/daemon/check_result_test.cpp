// Profiles with one thing wrong: what a machinist finds at the stops of `machine check`, by the simulated
// machine's frames, tells which one.

#include "daemon/measure/check_result.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

#include "daemon/post/machine_check.h"
#include "kinematics/basics/decimal.h"
#include "sim/motion/forward.h"

namespace tiltfeed::daemon {
namespace {

constexpr double kLength = 80.0;

config::MachineProfile shipped_profile(const std::string& name) {
  const auto profile = config::load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml");
  EXPECT_TRUE(profile) << profile.error().message;
  return profile.value_or(config::MachineProfile{});
}

double height_of(const config::MachineProfile& machine) { return machine.model.z.max < 50.0 ? -50.0 : 50.0; }

/// The words at which the real machine's tip is where it was at stop 1, or how far off it is there. `zero`:
/// how far the program's zero is off the table's point.
std::string found(const config::MachineProfile& profile, const MachineModel& real, bool off, Vec3 zero = {},
                  double aside = 0.0) {
  Setup setup;
  setup.tool_length = kLength;
  setup.part_zero = zero;
  constexpr double noise = 0.004;
  std::string table = off ? "stop,dx_mm,dy_mm,dz_mm\n" : "stop,x_mm,y_mm,z_mm\n";
  const auto stops = check_stops(profile, kLength, height_of(profile), aside);
  EXPECT_TRUE(stops);
  const Point<Part> ball = sim::forward_by_frames(real, setup, stops->front().joints).tip;
  for (std::size_t i = 0; i < stops->size(); ++i) {
    const Joints q = (*stops)[i].joints;
    const auto tip = [&](Vec3 d) {
      return sim::forward_by_frames(real, setup, {q.x + d.x, q.y + d.y, q.z + d.z, q.a, q.c}).tip;
    };
    const Vec3 way = ball - tip({}), x = tip({1, 0, 0}) - tip({}), y = tip({0, 1, 0}) - tip({}),
               z = tip({0, 0, 1}) - tip({});
    // The last digit of a dial.
    const Vec3 d{dot(way, x) + noise * std::sin(7.0 * i), dot(way, y) + noise * std::sin(11.0 * i),
                 dot(way, z)};
    const Vec3 said = off ? d * -1.0 : Vec3{q.x, q.y, q.z} + d;
    table += std::to_string(i + 1) + "," + decimal(said.x, 3) + "," + decimal(said.y, 3) + "," +
             decimal(said.z, 3) + "\n";
  }
  return table;
}

CheckResult judged(const config::MachineProfile& profile, const std::string& table, double aside = 0.0) {
  const auto result = judge_check(profile, kLength, height_of(profile), aside, table, "found.csv", 0.02);
  EXPECT_TRUE(result) << result.error().message;
  return result.value_or(CheckResult{});
}

bool offers(const CheckResult& result, const std::string& change) {
  for (const CheckRemedy& one : result.remedies)
    if (one.change == change) return true;
  return false;
}

/// How far the pivot that is offered lies off the real one, across the tilt's axis (along it nothing shows).
double off_pivot(const CheckResult& result, const MachineModel& profile, double lower) {
  for (const CheckRemedy& one : result.remedies) {
    Vec3 g;
    if (std::sscanf(one.change.c_str(), "pivot_to_gauge_mm: [%lf, %lf, %lf]", &g.x, &g.y, &g.z) != 3)
      continue;
    const Vec3 off = g - profile.pivot_to_gauge - Vec3{0, 0, lower};
    return length(cross(profile.tilt.direction, off));
  }
  return 1e9;
}

TEST(CheckResult, PassesEveryShippedProfileOnItsOwnMachine) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc", "dmu-nutating-bc",
                           "vmc-bhead-bc", "linuxcnc-max5", "mill-4x-table-a", "mill-4x-head-b"}) {
    const config::MachineProfile profile = shipped_profile(name);
    for (const bool off : {false, true}) {
      const CheckResult result = judged(profile, found(profile, profile.model, off));
      EXPECT_TRUE(result.passed) << name << ": " << text_of(result, 0.02);
      EXPECT_LT(result.worst, 0.01);
    }
  }
}

// On each structure one thing is wrong in the profile; the remedy is the real machine's value.
TEST(CheckResult, TellsWhatToChange) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc", "dmu-nutating-bc"}) {
    SCOPED_TRACE(name);
    const config::MachineProfile profile = shipped_profile(name);
    const auto with = [&](const std::function<void(MachineModel&)>& change) {
      MachineModel real = profile.model;
      change(real);
      const CheckResult result = judged(profile, found(profile, real, false));
      EXPECT_FALSE(result.passed);
      return result;
    };
    const int tilt = -profile.model.tilt.sign;
    const CheckResult sign = with([](MachineModel& m) { m.tilt.sign = -m.tilt.sign; });
    EXPECT_TRUE(offers(sign, "tilt.sign: " + std::to_string(tilt))) << text_of(sign, 0.02);
    EXPECT_GT(sign.worst, 1.0);
    if (profile.model.structure != Structure::kTableTable) {
      const CheckResult pivot = with([](MachineModel& m) { m.pivot_to_gauge.z -= 0.4; });
      EXPECT_LT(off_pivot(pivot, profile.model, -0.4), 0.03) << text_of(pivot, 0.02);
      const CheckResult zero = with([](MachineModel& m) { m.tilt.zero += 0.3; });
      EXPECT_NE(text_of(zero, 0.02).find("tilt.zero_deg: 0."), std::string::npos) << text_of(zero, 0.02);
    }
  }
  const config::MachineProfile profile = shipped_profile("generic-ac");
  const CheckResult off_axis = judged(profile, found(profile, profile.model, true, {0.3, -0.2, 0}));
  EXPECT_FALSE(off_axis.passed);
  ASSERT_FALSE(off_axis.remedies.empty());
  EXPECT_NE(text_of(off_axis, 0.02).find("the work zero moved by [-0.3"), std::string::npos)
      << text_of(off_axis, 0.02);
}

// A tip on a table's axis stays there whichever way the table turns: that is said, and a tip beside it shows
// it.
TEST(CheckResult, DoesNotPassASignThatItCannotSee) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "mill-4x-table-a"}) {
    SCOPED_TRACE(name);
    const config::MachineProfile profile = shipped_profile(name);
    MachineModel real = profile.model;
    real.rotary.sign = -real.rotary.sign;
    const double aside = profile.model.rotary.direction.x == 0.0 ? 50.0 : 0.0;
    if (aside > 0.0) {
      const CheckResult blind = judged(profile, found(profile, real, false));
      EXPECT_EQ(blind.unseen, std::vector<std::string>{"rotary.sign"}) << text_of(blind, 0.02);
      EXPECT_NE(text_of(blind, 0.02).find("do not tell rotary.sign"), std::string::npos);
    }
    const CheckResult seen = judged(profile, found(profile, real, true, {}, aside), aside);
    EXPECT_FALSE(seen.passed);
    EXPECT_TRUE(offers(seen, "rotary.sign: " + std::to_string(real.rotary.sign))) << text_of(seen, 0.02);
    const CheckResult right = judged(profile, found(profile, profile.model, true, {}, aside), aside);
    EXPECT_TRUE(right.passed) << text_of(right, 0.02);
    EXPECT_TRUE(right.unseen.empty());
  }
}

TEST(CheckResult, SaysWhatIsWrongWithATable) {
  const config::MachineProfile profile = shipped_profile("generic-ac");
  const std::string head = "stop,x_mm,y_mm,z_mm\n";
  for (const auto& [table, expected] : {std::pair<std::string, std::string>{"", "has 0 stops"},
                                        {"stop,x,y,z\n", "f.csv:1: expected the columns"},
                                        {head + "1,2,3\n", "f.csv:2: expected four values"},
                                        {head + "1,2,3,a\n", "f.csv:2: 'a' is no number"},
                                        {head + "99,1,2,3\n", "f.csv:2: stop '99' is none of the program's"},
                                        {head + "1,1,2,3\n1,1,2,3\n", "f.csv:3: stop 1 is there twice"}}) {
    const auto result = judge_check(profile, kLength, 50.0, 0.0, table, "f.csv", 0.02);
    ASSERT_FALSE(result) << table;
    EXPECT_NE(result.error().message.find(expected), std::string::npos) << result.error().message;
  }
}

}  // namespace
}  // namespace tiltfeed::daemon
