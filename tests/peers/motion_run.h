#pragma once
// Blocks for the axes of the simulated machine, a machine with limits of acceleration and jerk, and what a
// run of the blocks on it gave.

#include <gtest/gtest.h>

#include <vector>

#include "sim/motion/motion.h"
#include "tests/peers/sim_machine.h"

namespace tiltfeed::sim {
using namespace config;

inline constexpr double kAcceleration = 1000.0;  // mm/s^2, degrees/s^2
inline constexpr double kJerk = 20000.0;         // per s^3

inline MachineModel heavy_machine(double jerk = 0.0) {
  MachineModel machine = test_machine();
  for (LinearAxis* axis : {&machine.x, &machine.y, &machine.z})
    axis->acceleration = kAcceleration, axis->jerk = jerk;
  for (RotaryAxis* axis : {&machine.tilt, &machine.rotary})
    axis->acceleration = kAcceleration, axis->jerk = jerk;
  return machine;
}

inline Block feed(const Joints& target, double mm_per_min) {
  Block block;
  block.op = Op::kFeed, block.target = target, block.feed = mm_per_min;
  return block;
}

inline Block timed(const Joints& target, double seconds) {
  Block block = feed(target, 60.0 / seconds);
  block.inverse_time = true;
  return block;
}

inline Block rapid(const Joints& target) {
  Block block;
  block.target = target;
  return block;
}

inline Block code(int number) {
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
inline Executed run(const std::vector<Block>& program, const MachineModel& machine, std::size_t slots = 1000,
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

}  // namespace tiltfeed::sim
