// What must hold for the axes in simulated time whatever the program: random programs against the limits of
// the machine, sampled densely, and against each other.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>
#include <vector>

#include "tests/peers/motion_run.h"

namespace tiltfeed::sim {
using namespace config;
namespace {

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

}  // namespace
}  // namespace tiltfeed::sim
