// The axes in simulated time against closed forms, against integration step by step, and what must hold for
// any program.

#include "sim/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>
#include <vector>

#include "tests/sim_machine.h"

namespace tiltfeed::sim {
namespace {

constexpr double kAcceleration = 1000.0;  // mm/s^2, degrees/s^2
constexpr double kJerk = 20000.0;         // per s^3

MachineModel heavy_machine(double jerk = 0.0) {
  MachineModel machine = test_machine();
  for (LinearAxis* axis : {&machine.x, &machine.y, &machine.z})
    axis->acceleration = kAcceleration, axis->jerk = jerk;
  for (RotaryAxis* axis : {&machine.tilt, &machine.rotary})
    axis->acceleration = kAcceleration, axis->jerk = jerk;
  return machine;
}

Block feed(const Joints& target, double mm_per_min) {
  Block block;
  block.op = Op::kFeed, block.target = target, block.feed = mm_per_min;
  return block;
}

Block timed(const Joints& target, double seconds) {
  Block block = feed(target, 60.0 / seconds);
  block.inverse_time = true;
  return block;
}

Block rapid(const Joints& target) {
  Block block;
  block.target = target;
  return block;
}

Block code(int number) {
  Block block;
  block.op = Op::kMCode, block.m_code = number;
  return block;
}

struct Executed {
  std::vector<TraceRow> rows;
  MotionTotals totals;
  double seconds() const { return totals.busy; }
};

/// As fast as the slots allow.
Executed run(const std::vector<Block>& program, const MachineModel& machine, std::size_t slots = 1000,
             const MotionOptions& options = {}) {
  Executed run;
  Motion motion(
      machine, {}, slots, [&](const TraceRow& row) { run.rows.push_back(row); }, options);
  for (const Block& block : program) {
    while (motion.free_slots() == 0) motion.advance(*motion.next_event());
    motion.push(block);
  }
  while (const auto event = motion.next_event()) motion.advance(*event);
  EXPECT_TRUE(motion.idle());
  run.totals = motion.totals();
  return run;
}

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

// What must hold for any program.

std::vector<Block> random_program(std::mt19937& random, int blocks) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::normal_distribution<double> step(0.0, 1.0);
  std::vector<Block> program;
  Joints at{};
  const double size = std::pow(10.0, 2 * share(random) - 1);  // mm, degrees
  Joints direction{step(random), step(random), step(random), step(random), step(random)};
  for (int i = 0; i < blocks; ++i) {
    if (share(random) < 0.2)
      direction = {step(random), step(random), step(random), step(random), step(random)};
    const double turn = share(random) < 0.3 ? 0.0 : 1.0;
    at = {at.x + size * direction.x, at.y + size * (direction.y + 0.1 * step(random)),
          at.z + size * direction.z, at.a + turn * size * direction.a, at.c + turn * size * direction.c};
    const double kind = share(random);
    program.push_back(kind < 0.1   ? rapid(at)
                      : kind < 0.5 ? timed(at, 0.001 + 0.1 * share(random))
                                   : feed(at, 100 + 20000 * share(random)));
    if (share(random) < 0.05) program.back().exact_stop = true;
    if (share(random) < 0.02) program.push_back(code(8));
  }
  return program;
}

MachineModel wide_machine(double jerk) {
  MachineModel machine = heavy_machine(jerk);
  for (LinearAxis* axis : {&machine.x, &machine.y, &machine.z}) axis->min = -1e6, axis->max = 1e6;
  machine.x.acceleration = 400, machine.rotary.acceleration = 3000;  // not all alike
  machine.rotary.jerk = 3 * jerk;
  return machine;
}

/// Samples a run every `dt` and holds the differences against the limits; corners may add their jump.
void expect_within_limits(const std::vector<Block>& program, const MachineModel& machine) {
  const MotionOptions options;
  const double dt = 1e-4;
  std::vector<AxisVector> q;
  std::vector<double> ends;
  Motion motion(
      machine, {}, 64, [&](const TraceRow& row) { ends.push_back(row.end); }, options);
  std::size_t next = 0;
  for (double t = 0.0; next < program.size() || !motion.idle(); t += dt) {
    while (true) {
      while (next < program.size() && motion.free_slots() > 0) motion.push(program[next++]);
      const auto event = motion.next_event();
      if (!event || *event > t) break;
      motion.advance(*event);
    }
    motion.advance(t);
    q.push_back(axes_of(motion.position()));
    ASSERT_LT(t, 1000.0);
  }
  const double velocity[] = {1000, 1000, 1000, 600, 600};
  const double acceleration[] = {machine.x.acceleration, machine.y.acceleration, machine.z.acceleration,
                                 machine.tilt.acceleration, machine.rotary.acceleration};
  const double jerk[] = {machine.x.jerk, machine.y.jerk, machine.z.jerk, machine.tilt.jerk,
                         machine.rotary.jerk};
  std::size_t end = 0, smooth = 0;
  for (std::size_t i = 3; i < q.size(); ++i) {
    const double from = (static_cast<double>(i) - 3.001) * dt, to = (static_cast<double>(i) + 0.001) * dt;
    while (end < ends.size() && ends[end] < from) ++end;
    const bool corner = end < ends.size() && ends[end] <= to;
    for (std::size_t k = 0; k < 5; ++k) {
      const double v1 = (q[i][k] - q[i - 1][k]) / dt, v0 = (q[i - 1][k] - q[i - 2][k]) / dt;
      const double a1 = (v1 - v0) / dt, a0 = (q[i - 1][k] - 2 * q[i - 2][k] + q[i - 3][k]) / dt / dt;
      const double noise = 1e-13 * std::abs(q[i][k]) / dt / dt;
      ASSERT_LE(std::abs(v1), velocity[k] * (1 + 1e-9) + noise * dt) << i << " axis " << k;
      // Up to several short blocks in one step: their corners add up to no more than what lies in it.
      if (corner) {
        ASSERT_LE(std::abs(v1 - v0), acceleration[k] * (options.corner_time * 2 + 2 * dt))
            << i << " axis " << k;
        continue;
      }
      ++smooth;
      ASSERT_LE(std::abs(a1), acceleration[k] * (1 + 1e-6) + 4 * noise) << i << " axis " << k;
      if (jerk[k] > 0.0) {
        ASSERT_LE(std::abs(a1 - a0) / dt, jerk[k] * (1 + 1e-6) + 10 * noise / dt) << i << " axis " << k;
      }
    }
  }
  EXPECT_GT(smooth, 100U);
}

TEST(Motion, NoAxisExceedsItsLimits) {
  std::mt19937 random(11);
  for (int round = 0; round < 12 && !testing::Test::HasFatalFailure(); ++round)
    expect_within_limits(random_program(random, 150), wide_machine(round % 2 == 0 ? 0.0 : kJerk));
}

TEST(Motion, EndsExactlyNeverFasterThanItsWordsAndInOrder) {
  std::mt19937 random(12);
  for (int round = 0; round < 20; ++round) {
    const std::vector<Block> program = random_program(random, 400);
    const MachineModel machine = wide_machine(round % 2 == 0 ? 0.0 : kJerk);
    MachineModel light = machine;
    for (LinearAxis* axis : {&light.x, &light.y, &light.z}) axis->acceleration = axis->jerk = 0.0;
    for (RotaryAxis* axis : {&light.tilt, &light.rotary}) axis->acceleration = axis->jerk = 0.0;
    const Executed real = run(program, machine, 40), least = run(program, light, 40);
    ASSERT_EQ(real.rows.size(), program.size());
    double busy = 0.0;
    for (std::size_t i = 0; i < program.size(); ++i) {
      const TraceRow &row = real.rows[i], &bound = least.rows[i];
      const bool moves = program[i].op != Op::kMCode;
      if (moves) {
        ASSERT_EQ(row.command.target, program[i].target);
        ASSERT_GE(row.peak_rate * (row.end - row.start), 1 - 1e-9) << "the peak is above the mean";
      }
      ASSERT_GE(row.end - row.start, (bound.end - bound.start) * (1 - 1e-9));
      ASSERT_EQ(row.start, i == 0 ? 0.0 : real.rows[i - 1].end);
      busy += row.end - row.start;
    }
    EXPECT_NEAR(real.seconds(), busy, 1e-9);
    EXPECT_EQ(real.totals.starved, 0.0);
  }
}

TEST(Motion, LongerLookAheadIsNeverSlower) {
  std::mt19937 random(13);
  for (int round = 0; round < 20; ++round) {
    const std::vector<Block> program = random_program(random, 300);
    const MachineModel machine = wide_machine(round % 2 == 0 ? 0.0 : kJerk);
    double before = kUnlimited;
    for (const std::size_t blocks : {1U, 2U, 3U, 5U, 8U, 13U, 21U, 55U, 400U}) {
      const double seconds = run(program, machine, blocks).seconds();
      EXPECT_LE(seconds, before * (1 + 1e-9)) << round << " " << blocks;
      before = seconds;
    }
    EXPECT_LT(before, 0.95 * run(program, machine, 1).seconds()) << "it matters";
  }
}

TEST(Motion, PushingWhileItMovesIsNoWorseThanKnowingLess) {
  // A host that comes late: blocks arrive while the axes move. It still ends exactly and breaks no limit of
  // time.
  std::mt19937 random(14);
  const std::vector<Block> program = random_program(random, 300);
  for (const double jerk : {0.0, kJerk}) {
    std::vector<TraceRow> rows;
    Motion motion(wide_machine(jerk), {}, 50, [&](const TraceRow& row) { rows.push_back(row); });
    std::uniform_real_distribution<double> pause(0.0, 0.05);
    for (const Block& block : program) {
      motion.advance(motion.now() + pause(random));
      while (motion.free_slots() == 0) motion.advance(*motion.next_event());
      motion.push(block);
    }
    while (const auto event = motion.next_event()) motion.advance(*event);
    ASSERT_EQ(rows.size(), program.size());
    EXPECT_GE(motion.totals().busy, run(program, wide_machine(jerk), 400).seconds() * (1 - 1e-9));
    EXPECT_LE(motion.totals().busy, run(program, wide_machine(jerk), 1).seconds() * (1 + 1e-9));
  }
}

TEST(Motion, SameCallsSameRows) {
  std::mt19937 random(15);
  const std::vector<Block> program = random_program(random, 300);
  const auto text = [&] {
    std::ostringstream out;
    for (const TraceRow& row : run(program, wide_machine(kJerk), 20).rows) write_trace_row(row, out);
    return out.str();
  };
  EXPECT_EQ(text(), text());
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

TEST(Motion, HoldAndResumeAtAnyMomentChangeNothingButTime) {
  std::mt19937 random(16);
  std::uniform_real_distribution<double> pause(0.0, 0.2);
  for (const double jerk : {0.0, kJerk}) {
    const std::vector<Block> program = random_program(random, 200);
    std::vector<TraceRow> rows;
    Motion motion(wide_machine(jerk), {}, 300, [&](const TraceRow& row) { rows.push_back(row); });
    for (const Block& block : program) motion.push(block);
    for (int i = 0; !motion.idle() && i < 100000; ++i) {
      motion.advance(motion.now() + pause(random));
      if (i % 3 == 0) motion.set_feed_override(static_cast<int>(10 + random() % 190));
      if (motion.held()) {
        motion.resume();
      } else {
        motion.hold();
      }
    }
    ASSERT_EQ(rows.size(), program.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (program[i].op == Op::kMCode) continue;
      ASSERT_EQ(rows[i].command.target, program[i].target);
    }
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
