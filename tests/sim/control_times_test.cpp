// The times that planning foresees against those of the simulated axes, on random programs: the two share no
// code, and find ramps by other methods.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinematics/timing/control_timing.h"
#include "sim/removal/executed_path.h"

namespace tiltfeed::sim {
namespace {

MachineModel random_machine(std::mt19937& random, bool jerk) {
  std::uniform_real_distribution<double> any(0.0, 1.0);
  MachineModel m;
  m.name = "test";
  for (LinearAxis* axis : {&m.x, &m.y, &m.z})
    *axis = {-5000, 5000, 20000, 500 + 2000 * any(random), jerk ? 1e4 + 1e5 * any(random) : 0.0};
  m.tilt = {'A', {1, 0, 0}, +1, 0, -5000, 5000, 7200, 300 + 500 * any(random)};
  m.rotary = {'C', {0, 0, 1}, -1, 0, -36000, 36000, 14400, 500 + 900 * any(random)};
  if (jerk) m.tilt.jerk = 5e3 + 2e4 * any(random), m.rotary.jerk = 1e4 + 4e4 * any(random);
  m.pivot_to_gauge = {0, 0, -50};
  return m;
}

/// A curve of short chords with corners, rapids and rotaries that turn now and then.
std::vector<JointMove> random_moves(std::mt19937& random, const MachineModel& machine, double chord) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<JointMove> moves{{}};
  double heading = 0.0, turning = 0.0, spin = 0.0;
  for (int i = 0; i < 1500; ++i) {
    if (i % 40 == 0) turning = 0.08 * any(random), spin = i % 80 == 0 ? 0.4 * any(random) : 0.0;
    if (i % 90 == 89) heading += 3.0 * any(random);
    heading += turning;
    JointMove next = moves.back();
    const bool rapid = i % 300 > 290;
    const double way = chord * (1.0 + 0.5 * any(random)) * (rapid ? 20.0 : 1.0);
    next.joints.x += way * std::cos(heading), next.joints.y += way * std::sin(heading);
    next.joints.z += 0.05 * way * any(random);
    next.joints.c += spin * way, next.joints.a += 0.3 * spin * way;
    next.kind = rapid ? MoveKind::kRapid : MoveKind::kCut;
    next.seconds = rapid_seconds(machine, moves.back().joints, next.joints);
    if (!rapid) next.seconds = std::max(next.seconds, way / (i % 500 < 250 ? 40.0 : 15.0));
    moves.push_back(next);
  }
  return moves;
}

/// What the simulated axes take from the first place on.
double executed_seconds(const std::vector<JointMove>& moves, const MachineModel& machine,
                        const ControlPace& pace) {
  std::vector<Block> program;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    Block block;
    block.op = moves[i].kind == MoveKind::kRapid ? Op::kRapid : Op::kFeed;
    block.target = moves[i].joints, block.inverse_time = true;
    if (block.op == Op::kFeed) block.feed = 60.0 / moves[i].seconds;
    block.line = static_cast<std::uint32_t>(i + 1);
    program.push_back(block);
  }
  MotionOptions options;
  options.look_ahead = pace.look_ahead, options.corner_time = pace.corner_time;
  const auto path = execute_program(program, "p.nc", machine, {}, options);
  EXPECT_TRUE(path) << path.error().message;
  double seconds = 0.0;
  for (const ExecutedMove& move : path->moves) seconds += move.end - move.start;
  return seconds;
}

TEST(ControlTimes, RandomPrograms) {
  std::mt19937 random(41);
  for (const bool jerk : {false, true})
    for (const std::size_t known : {20u, 200u, 3000u})
      for (const double chord : {0.05, 0.3, 2.0})
        for (int round = 0; round < 3; ++round) {
          const MachineModel machine = random_machine(random, jerk);
          const std::vector<JointMove> moves = random_moves(random, machine, chord);
          const ControlPace pace{0.002 + 0.003 * round, known, 0.0};
          const double foreseen = time_on_control(moves, machine, pace).seconds,
                       executed = executed_seconds(moves, machine, pace);
          EXPECT_NEAR(foreseen / executed, 1.0, known == 3000u ? 1e-4 : 0.01)
              << (jerk ? "jerk " : "") << known << " known, chord " << chord << ": " << foreseen << " s, "
              << executed;
        }
}

}  // namespace
}  // namespace tiltfeed::sim
