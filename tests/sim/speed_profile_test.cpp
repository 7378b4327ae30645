// Speed along one block: the closed forms against their definitions, profiles against numerical integration.

#include "sim/motion/speed_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tiltfeed::sim {
namespace {

struct Dice {
  std::mt19937 random{21};
  double exponential(double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0.0, 1.0)(random));
  }
};

/// The definition of (M7): the longest ramp between `high` and any speed from `low` to `high`.
double longest_ramp(double high, double low, const PathLimits& limits) {
  double longest = 0.0;
  for (int i = 0; i <= 2000; ++i)
    longest = std::max(longest, ramp_length(low + (high - low) * i / 2000.0, high, limits));
  return longest;
}

TEST(SpeedProfile, HighestAndLowestAreWhereTheLongestRampJustFits) {
  Dice dice;
  for (int i = 0; i < 3000; ++i) {
    PathLimits limits;
    limits.acceleration = i % 7 == 0 ? kUnlimited : dice.exponential(0.1, 10.0);
    limits.jerk = i % 5 == 0 && i % 7 != 0 ? kUnlimited : dice.exponential(0.01, 100.0);
    const double from = i % 11 == 0 ? 0.0 : dice.exponential(0.001, 30.0),
                 length = dice.exponential(1e-3, 30.0);
    const double high = highest_after(from, length, limits), low = lowest_after(from, length, limits);
    ASSERT_GE(high, from);
    ASSERT_LE(low, from);
    // The difference of two speeds keeps what digits it has left.
    const auto close = [&](double change) { return 1e-5 + 1e-15 * from / change; };
    EXPECT_NEAR(longest_ramp(high, from, limits) / length, 1.0, close(high - from)) << i;
    if (low > 0.0) {
      EXPECT_NEAR(longest_ramp(from, low, limits) / length, 1.0, close(from - low))
          << i << " down from " << from;
    } else {
      EXPECT_LE(longest_ramp(from, 0.0, limits), length * (1 + 1e-9)) << i;
    }
    EXPECT_LE(lowest_after(high, length, limits), from + 1e-6 * high)
        << i << ": what was reached can be left";
    EXPECT_LE(high, highest_after(from * 1.01, length, limits)) << "never falls with the speed";
    EXPECT_LE(high, highest_after(from, length * 1.01, limits)) << "nor with the length";
  }
}

TEST(SpeedProfile, IsTheIntegralOfItsOwnJerkAndKeepsItsLimits) {
  Dice dice;
  for (int i = 0; i < 400; ++i) {
    PathLimits limits{dice.exponential(0.5, 5.0), dice.exponential(0.5, 10.0),
                      i % 4 == 0 ? kUnlimited : dice.exponential(1.0, 100.0)};
    const double length = dice.exponential(0.01, 10.0), entry = limits.speed * dice.exponential(0.01, 1.0);
    const double exit = std::clamp(limits.speed * dice.exponential(0.01, 1.0),
                                   lowest_after(entry, length, limits), highest_after(entry, length, limits));
    const auto profile = SpeedProfile::to({0.0, entry, 0.0}, length, std::min(exit, limits.speed), limits);
    ASSERT_TRUE(profile);
    const int steps = 4000;
    const double dt = profile->seconds() / steps;
    double s = 0.0;
    PathState before = profile->at(0.0);
    for (int k = 1; k <= steps; ++k) {
      const PathState now = profile->at(k * dt);
      s += (before.v + now.v) / 2 * dt;
      ASSERT_LE(now.v, limits.speed * (1 + 1e-9)) << i;
      ASSERT_GE(now.v, -1e-12) << i;
      ASSERT_LE(std::abs(now.v - before.v), limits.acceleration * dt * (1 + 1e-6) + 1e-12) << i;
      const double jerk = std::abs(now.a - before.a) / dt;
      ASSERT_LE(jerk, limits.jerk * (1 + 1e-6) + 1e-9 / dt) << i;
      ASSERT_NEAR(now.s, s, 1e-5 * length) << i;
      before = now;
    }
    EXPECT_EQ(profile->end().s, length);
    const PathPeaks peaks = profile->peaks(profile->seconds());
    EXPECT_LE(peaks.acceleration, limits.acceleration * (1 + 1e-9));
    EXPECT_GE(peaks.speed * profile->seconds(), length * (1 - 1e-9));
  }
}

TEST(SpeedProfile, HaltsFromAnyState) {
  const PathLimits limits{10.0, 2.0, 4.0};
  // v = 3 and still accelerating with 2: 0.5 s to end that, 0.5 mm/s faster then; down from 3.5.
  const SpeedProfile halt = SpeedProfile::halt({1.0, 3.0, 2.0}, limits);
  EXPECT_NEAR(halt.seconds(), 0.5 + 3.5 / 2 + 0.5, 1e-12);
  EXPECT_NEAR(halt.end().s, 1 + 3 * 0.5 + 2 * 0.125 - 4 * 0.125 / 6 + 3.5 / 2 * 2.25, 1e-12);
  EXPECT_EQ(halt.end().v, 0.0);
  EXPECT_FALSE(SpeedProfile::to({1.0, 3.0, 2.0}, 2.5, 0.0, limits)) << "1.67 mm go by until then";
}

}  // namespace
}  // namespace tiltfeed::sim
