// The axes in simulated time against closed forms and against integration step by step.

#include "sim/motion/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/peers/motion_run.h"

namespace tiltfeed::sim {
using namespace config;
namespace {

double single(double way, double mm_per_min, double jerk = 0.0) {
  return run({feed({way, 0, 0, 0, 0}, mm_per_min)}, heavy_machine(jerk)).seconds();
}

// Closed forms: way d, speed v, acceleration a, jerk j.

TEST(Motion, OneMoveIsATrapezoidOrATriangle) {
  const double v = 100.0;  // mm/s
  EXPECT_NEAR(single(50, 60 * v), 50 / v + v / kAcceleration, 1e-12);
  EXPECT_NEAR(single(10, 60 * v), 10 / v + v / kAcceleration, 1e-12) << "just reaches its speed";
  EXPECT_NEAR(single(4, 60 * v), 2 * std::sqrt(4 / kAcceleration), 1e-12);
}

TEST(Motion, OneMoveWithAJerkLimitHasSevenPhasesOrFewer) {
  const double a = kAcceleration, j = kJerk, v = 100.0;  // a^2 / j = 50 mm/s: the ramp has a constant part
  EXPECT_NEAR(single(50, 60 * v, j), 50 / v + v / a + a / j, 1e-12) << "seven";
  EXPECT_NEAR(single(50, 60 * 20.0, j), 50 / 20.0 + 2 * std::sqrt(20 / j), 1e-12) << "five: a is not reached";
  EXPECT_NEAR(single(1, 60 * v, j), 4 * std::cbrt(1 / (2 * j)), 1e-9) << "four: neither a nor v";
  // six: v is not reached; top speed p from p (p / a + a / j) = way
  const double way = 12, p = (-a * a / j + std::sqrt(a * a * a * a / j / j + 4 * a * way)) / 2;
  ASSERT_GT(p, 50.0);
  EXPECT_NEAR(single(way, 60000, j), 2 * (p / a + a / j), 1e-9);
}

TEST(Motion, TheAxisThatIsNearestToItsLimitDecides) {
  MachineModel machine = heavy_machine(kJerk);
  machine.x.acceleration = 600, machine.y.jerk = 8000;
  // 30 and 40 mm: along the way of 50 mm a is at most 600 / 0.6 and 1000 / 0.8, j at most 20000 / 0.6 and
  // 8000 / 0.8.
  const double v = 250.0, a = 1000.0, j = 10000.0;
  EXPECT_NEAR(run({feed({300, 400, 0, 0, 0}, 60 * v)}, machine).seconds(), 500 / v + v / a + a / j, 1e-9);
}

TEST(Motion, ARightAngleIsTakenAtTheSpeedThatTheCornerTimeAllows) {
  const double v = 100.0, corner = 0.02, c = kAcceleration * corner, a = kAcceleration;
  const auto time = [&](double corner_time) {
    return run({feed({50, 0, 0, 0, 0}, 60 * v), feed({50, 50, 0, 0, 0}, 60 * v)}, heavy_machine(), 10,
               {.corner_time = corner_time})
        .seconds();
  };
  // Each block: from rest to v, then down to c at the corner; the other mirrored.
  const double each = v / a + (v - c) / a + (50 - (v * v + v * v - c * c) / (2 * a)) / v;
  EXPECT_NEAR(time(corner), 2 * each, 1e-12);
  EXPECT_NEAR(time(0.0), 2 * (50 / v + v / a), 1e-12) << "exact stop";
  EXPECT_NEAR(time(0.2), 100 / v + v / a, 1e-12) << "no corner is too sharp";
}

TEST(Motion, ACircleOfChordsIsTakenAtTheSpeedOfItsCentripetalAcceleration) {
  const double radius = 5.0, a = kAcceleration;
  const int chords = 3600;
  std::vector<Block> program;
  for (int i = 1; i <= chords; ++i) {
    const double t = 2 * kPi * i / chords;
    program.push_back(feed({radius * (1 - std::cos(t)), radius * std::sin(t), 0, 0, 0}, 60000));
  }
  const Executed circle = run(program, heavy_machine(), 4000);
  const Pose from = circle.rows[1000].pose, to = circle.rows[2600].pose;
  const double seconds = circle.rows[2600].end - circle.rows[1000].end;
  EXPECT_NEAR(distance(from.tip, to.tip), 2 * radius * std::sin(kPi * 1600 / 3600), 1e-6);
  // On X and Y together it is sqrt(a r) where one axis alone turns, more at 45 degrees, never over 2^(1/4) of
  // it.
  const double speed = 2 * kPi * radius * 1600 / chords / seconds;
  EXPECT_GT(speed, 0.999 * std::sqrt(a * radius));
  EXPECT_LT(speed, 1.19 * std::sqrt(a * radius));
}

TEST(Motion, FeedIsThatOfTheModeAndTheDialect) {
  const MachineModel machine = test_machine();  // no acceleration limit
  const Joints both{30, 40, 0, 0, 120}, turn{0, 0, 0, 30, 40};
  EXPECT_DOUBLE_EQ(run({timed(both, 2.5)}, machine).seconds(), 2.5);
  EXPECT_DOUBLE_EQ(run({feed(both, 3000)}, machine).seconds(), 1.0) << "X Y Z: 50 mm";
  EXPECT_DOUBLE_EQ(run({feed(both, 3000)}, machine, 5, {.feed_over_all_axes = true}).seconds(), 2.6) << "130";
  EXPECT_DOUBLE_EQ(run({feed(turn, 3000)}, machine).seconds(), 1.0) << "50 degrees";
  EXPECT_DOUBLE_EQ(run({rapid(both)}, machine).seconds(), 0.2) << "120 degrees at 600 degrees/s";
}

TEST(Motion, ExactStopAndRotaryRuleStopBetweenBlocks) {
  std::vector<Block> line, turning;
  for (int i = 1; i <= 10; ++i) {
    line.push_back(feed({10.0 * i, 0, 0, 0, 0}, 6000));
    turning.push_back(timed({10.0 * i, 0, 0, 0, 10.0 * i}, 0.1));
  }
  const double stops = 10 * (0.1 + 0.1), flows = 1.0 + 0.1;
  EXPECT_NEAR(run(line, heavy_machine()).seconds(), flows, 1e-9);
  std::vector<Block> exact = line;
  for (Block& block : exact) block.exact_stop = true;
  EXPECT_NEAR(run(exact, heavy_machine()).seconds(), stops, 1e-9);
  EXPECT_NEAR(run(turning, heavy_machine()).seconds(), flows, 1e-9);
  EXPECT_NEAR(run(turning, heavy_machine(), 10, {.blend_rotary = false}).seconds(), stops, 1e-9);
  EXPECT_NEAR(run(line, heavy_machine(), 10, {.blend_rotary = false}).seconds(), flows, 1e-9);
}

TEST(Motion, DwellsAndCodesStopTheAxes) {
  Block dwell;
  dwell.op = Op::kDwell, dwell.feed = 0.5;
  const Block first = feed({10, 0, 0, 0, 0}, 6000), second = feed({20, 0, 0, 0, 0}, 6000);
  EXPECT_NEAR(run({first, second}, heavy_machine()).seconds(), 0.3, 1e-12);
  EXPECT_NEAR(run({first, dwell, second}, heavy_machine()).seconds(), 0.9, 1e-12);
  EXPECT_NEAR(run({first, code(8), second}, heavy_machine()).seconds(), 0.4, 1e-12);
}

TEST(Motion, ABlockThatGoesNowhereIsNoStop) {
  const Block first = feed({10, 0, 0, 0, 0}, 6000), second = feed({20, 0, 0, 0, 0}, 6000);
  EXPECT_NEAR(run({first, first, timed(first.target, 1), second, second}, heavy_machine()).seconds(), 0.3,
              1e-9);
}

/// Blocks of 1 mm at 100 mm/s, a = 1000: to stand it needs 5 of them.
std::vector<Block> straight(int blocks) {
  std::vector<Block> program;
  for (int i = 1; i <= blocks; ++i) program.push_back(feed({i * 1.0, 0, 0, 0, 0}, 6000));
  return program;
}

TEST(Motion, ShortLookAheadIsSlow) {
  // It must be able to stand at the end of what it knows: with n blocks known the speed at a block's start is
  // at most sqrt(2 a n), the way being n mm.
  for (const std::size_t n : {1U, 2U, 3U}) {
    const Executed slow = run(straight(400), heavy_machine(), n);
    const double begin = slow.rows[150].end, end = slow.rows[250].end;
    const double high = std::sqrt(2 * kAcceleration * static_cast<double>(n));
    const double low = std::sqrt(2 * kAcceleration * static_cast<double>(n - 1));
    if (n == 1) {
      EXPECT_NEAR((end - begin) / 100, 2 * std::sqrt(1 / kAcceleration), 1e-9);
    } else {
      EXPECT_GE((end - begin) / 100, 1 / high);
      EXPECT_LE((end - begin) / 100, 1 / low);
    }
    // The same from a window over a longer queue.
    EXPECT_NEAR(run(straight(400), heavy_machine(), 50, {.look_ahead = n}).seconds(), slow.seconds(), 1e-9);
  }
  EXPECT_NEAR(run(straight(400), heavy_machine(), 6).seconds(), 4 + 0.1, 1e-9) << "six are enough";
}

TEST(Motion, WaitsForBlocksAtRestAndCountsIt) {
  Motion motion(heavy_machine(), {}, 10, [](const TraceRow&) {});
  motion.push(feed({10, 0, 0, 0, 0}, 6000));
  motion.advance(0.15);  // at 5 mm and more it would have to brake from 100 mm/s
  motion.push(feed({20, 0, 0, 0, 0}, 6000));
  motion.advance(0.16);
  EXPECT_LT(motion.speed(), 6000.0) << "it had begun to brake";
  motion.advance(5.0);
  EXPECT_TRUE(motion.idle());
  motion.push(feed({30, 0, 0, 0, 0}, 6000));
  motion.advance(9.0);
  EXPECT_NEAR(motion.totals().starved, 5.0 - motion.totals().busy + 0.2, 1e-9);
}

// Integration step by step: brake where the way to a stop or to a slower corner asks for it, else accelerate.

TEST(Motion, AgreesWithIntegrationStepByStep) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> way(0.5, 20.0), speed(20.0, 200.0);
  for (int round = 0; round < 20; ++round) {
    // Along X only, forwards: the speed limits differ, no corner turns.
    std::vector<Block> program;
    std::vector<double> ends, limits;
    double x = 0.0;
    for (int i = 0; i < 12; ++i) {
      x += way(random);
      limits.push_back(speed(random)), ends.push_back(x);
      program.push_back(feed({x, 0, 0, 0, 0}, 60 * limits.back()));
    }
    const double planned = run(program, heavy_machine()).seconds();
    const double dt = 2e-6;
    double s = 0.0, v = 0.0, t = 0.0;
    for (std::size_t i = 0; s < x && t < 100.0; t += dt) {
      while (i + 1 < ends.size() && s >= ends[i]) ++i;
      double most = std::min(limits[i], v + kAcceleration * dt);
      for (std::size_t k = i; k < ends.size(); ++k) {
        const double next = k + 1 < ends.size() ? limits[k + 1] : 0.0;
        most = std::min(most, std::sqrt(next * next + 2 * kAcceleration * std::max(0.0, ends[k] - s)));
      }
      v = std::max(most, 0.05);  // so that the last thousandths of a millimetre end
      s += v * dt;
    }
    EXPECT_NEAR(planned, t, 2e-3 * t) << round;
  }
}

// Holds and overrides.

TEST(Motion, AHoldBrakesOverAsManyBlocksAsItTakesAndGoesOn) {
  for (const double jerk : {0.0, kJerk}) {
    std::vector<TraceRow> rows;
    Motion motion(heavy_machine(jerk), {}, 100, [&](const TraceRow& row) { rows.push_back(row); });
    const double longer =
        jerk == 0.0 ? 1.0 : 8.0;  // with a jerk limit a block of 1 mm does not reach 100 mm/s
    for (Block block : straight(60)) {
      block.target.x *= longer;
      motion.push(block);
    }
    motion.advance(jerk == 0.0 ? 0.3 : 1.005);
    ASSERT_NEAR(motion.speed(), 6000.0, 1e-6) << "at full speed";
    const double x = motion.position().x;
    motion.hold();
    EXPECT_TRUE(motion.held() && !motion.standing());
    while (const auto event = motion.next_event()) motion.advance(*event);
    EXPECT_TRUE(motion.standing());
    const double way = motion.position().x - x;
    if (jerk == 0.0) {
      EXPECT_NEAR(way, 5.0, 1e-9) << "v^2 / 2a, over five blocks";
      EXPECT_NEAR(motion.now(), 0.4, 1e-9);
    } else {
      // 7.5 mm is the ramp; it begins at once or, where less is left of the block, with the next one.
      EXPECT_GE(way, 7.5 - 1e-9);
      EXPECT_LT(way, 7.5 + 8.0);
    }
    const double busy = motion.totals().busy;
    motion.advance(10.0);
    EXPECT_EQ(motion.position().x, x + way);
    motion.resume();
    while (const auto event = motion.next_event()) motion.advance(*event);
    ASSERT_EQ(rows.size(), 60U);
    EXPECT_EQ(rows.back().command.target.x, 60.0 * longer);
    EXPECT_NEAR(motion.totals().busy, busy + rows.back().end - 10.0, 1e-9) << "the standstill does not count";
  }
}

TEST(Motion, AnOverrideChangesSpeedAtTheLimitOfAcceleration) {
  Motion motion(heavy_machine(), {}, 10, [](const TraceRow&) {});
  motion.push(feed({100, 0, 0, 0, 0}, 6000));
  motion.advance(0.5);
  motion.set_feed_override(50);
  EXPECT_NEAR(motion.speed(), 6000, 1e-6) << "not at once";
  motion.advance(0.525);
  EXPECT_NEAR(motion.speed(), 4500, 1e-6);
  motion.advance(0.6);
  EXPECT_NEAR(motion.speed(), 3000, 1e-6);
  motion.advance(10.0);
  // 45 mm before the change, 3.75 mm while braking, 1.25 mm at the end, 50 mm at 50 mm/s.
  EXPECT_NEAR(motion.totals().busy, 0.5 + 0.05 + 50 / 50.0 + 0.05, 1e-9);
}

}  // namespace
}  // namespace tiltfeed::sim
