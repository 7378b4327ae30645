// Times on a control that looks ahead: closed forms for one block and two, and an integration step by step
// for ramps.

#include "kinematics/timing/control_timing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinematics/timing/speed_ramp.h"

namespace tiltfeed {
namespace {

MachineModel limited(double jerk) {
  MachineModel m;
  for (LinearAxis* axis : {&m.x, &m.y, &m.z}) *axis = {-500, 500, 60000, 1000, jerk};
  m.tilt = {'A', {1, 0, 0}, +1, 0, -110, 110, 36000, 500};
  m.rotary = {'C', {0, 0, 1}, -1, 0, -36000, 36000, 36000, 500};
  m.tilt.jerk = m.rotary.jerk = jerk;
  return m;
}

std::vector<JointMove> along_x(const std::vector<double>& ends, double speed) {
  std::vector<JointMove> moves{{}};
  for (const double x : ends)
    moves.push_back({{x, 0, 0, 0, 0}, std::abs(x - moves.back().joints.x) / speed, MoveKind::kCut, 0});
  return moves;
}

/// The way of a ramp, step by step.
double integrated_way(double from, double to, const RampLimits& limits) {
  const double time = ramp_time(std::abs(to - from), limits), up = to > from ? 1.0 : -1.0;
  constexpr int kSteps = 200000;
  const double dt = time / kSteps;
  double v = from, a = 0.0, way = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) * dt;
    // The acceleration rises with the jerk, and falls so that it ends at zero.
    const double most = std::min({limits.acceleration, limits.jerk * t, limits.jerk * (time - t)});
    a = up * most;
    way += (v + 0.5 * a * dt) * dt;
    v += a * dt;
  }
  EXPECT_NEAR(v, to, 1e-6 * (1.0 + std::abs(to - from)));
  return way;
}

TEST(ControlTiming, RampsByIntegration) {
  for (const RampLimits limits : {RampLimits{1000, 20000}, RampLimits{1000, 1e7}, RampLimits{300, 5000}}) {
    for (const auto& [from, to] : {std::pair{0.0, 10.0}, {5.0, 200.0}, {80.0, 20.0}, {30.0, 31.0}})
      EXPECT_NEAR(ramp_way(from, to, limits), integrated_way(from, to, limits), 1e-5 * (from + to));
  }
}

TEST(ControlTiming, ReachedSpeedIsTheHighest) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (int i = 0; i < 3000; ++i) {
    const RampLimits limits{100.0 + 2000.0 * any(random), 1000.0 + 1e5 * any(random)};
    const double from = 200.0 * any(random) * any(random), way = 20.0 * any(random) * any(random) + 1e-4;
    const double high = reached_speed(from, way, limits);
    double longest = 0.0, beyond = 0.0;
    for (int k = 0; k <= 400; ++k) {
      longest = std::max(longest, ramp_way(from + (high - from) * k / 400, high, limits));
      beyond = std::max(beyond, ramp_way(from + (1.001 * high - from) * k / 400, 1.001 * high, limits));
    }
    EXPECT_LE(longest, way * (1.0 + 1e-9));
    EXPECT_GT(beyond, way * (1.0 - 1e-4)) << from << " " << way;
  }
}

// One block from rest to rest, long and short; (control_timing.h, properties 1 and 2).
TEST(ControlTiming, OneBlock) {
  // Trapezoid and triangle.
  EXPECT_NEAR(time_on_control(along_x({100}, 50), limited(0), {}).seconds, 100.0 / 50 + 50.0 / 1000, 1e-9);
  EXPECT_NEAR(time_on_control(along_x({0.9}, 50), limited(0), {}).seconds, 2 * std::sqrt(0.9 / 1000), 1e-9);
  // With jerk: L / v + v / a + a / j.
  EXPECT_NEAR(time_on_control(along_x({100}, 100), limited(20000), {}).seconds,
              100.0 / 100 + 100.0 / 1000 + 1000.0 / 20000, 1e-9);
  // So short that the acceleration is never reached: four times the cube root of L / 2 j.
  EXPECT_NEAR(time_on_control(along_x({0.5}, 100), limited(20000), {}).seconds,
              4 * std::cbrt(0.5 / (2 * 20000.0)), 1e-9);
  const Timing t = time_on_control(along_x({100}, 100), limited(20000), {});
  EXPECT_NEAR(t.peak_velocity.x, 6000.0, 1e-6);
  EXPECT_NEAR(t.peak_acceleration.x, 1000.0, 1e-6);
  EXPECT_EQ(time_on_control({}, limited(0), {}).seconds, 0.0);
  // The control takes no quicker block than this.
  EXPECT_NEAR(time_on_control(along_x({100}, 50), limited(0), {0.005, 200, 10.0}).seconds, 10.0 + 0.01, 1e-9);
}

TEST(ControlTiming, Corners) {
  // A right angle: each axis may change its speed by 1000 x 0.005 = 5 mm/s at once.
  std::vector<JointMove> moves = along_x({100}, 50);
  moves.push_back({{100, 100, 0, 0, 0}, 2.0, MoveKind::kCut, 0});
  const double half = 100.0 / 50 + (50.0 - 0.0) * (50.0 - 0.0) / (2 * 1000.0 * 50) +
                      (50.0 - 5.0) * (50.0 - 5.0) / (2 * 1000.0 * 50);
  EXPECT_NEAR(time_on_control(moves, limited(0), {}).seconds, 2 * half, 1e-9);
  // Straight on is no corner; an operation that begins is a stop.
  EXPECT_NEAR(time_on_control(along_x({50, 100}, 50), limited(0), {}).seconds, 2.05, 1e-9);
  std::vector<JointMove> two = along_x({50}, 50);
  two.push_back({{70, 0, 0, 0, 0}, 0.0, MoveKind::kRapid, 0});
  two.push_back({{120, 0, 0, 0, 0}, 1.0, MoveKind::kCut, 0});
  EXPECT_NEAR(time_on_control(two, limited(0), {}).seconds, 2 * 1.05, 1e-9);
}

// (control_timing.h, property 3) With so few blocks known the axes must be able to stand within them.
TEST(ControlTiming, LookAhead) {
  std::vector<double> ends;
  for (int i = 1; i <= 1000; ++i) ends.push_back(0.1 * i);
  double before = 1e9;
  for (const std::size_t known : {3u, 5u, 10u, 40u, 200u, 0u}) {
    const double seconds = time_on_control(along_x(ends, 50), limited(0), {0.005, known, 0.0}).seconds;
    EXPECT_LE(seconds, before * (1.0 + 1e-9)) << known;
    before = seconds;
    // A block ends no faster than what can be braked within known - 1 blocks.
    if (known > 0 && known <= 10) {
      const double braked = std::sqrt(2 * 1000.0 * 0.1 * (static_cast<double>(known) - 1.0));
      EXPECT_NEAR(seconds, 100.0 / braked, 0.25 * seconds);
    }
  }
  EXPECT_NEAR(before, 2.05, 1e-9);
}

}  // namespace
}  // namespace tiltfeed
