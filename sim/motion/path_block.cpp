#include "sim/motion/path_block.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

constexpr std::size_t kAxes = std::tuple_size_v<AxisVector>;
constexpr std::size_t kFirstRotary = 3;

// A limit of zero states none.
double limit_of(double stated) { return stated > 0.0 ? stated : kUnlimited; }

double norm(const AxisVector& v, std::size_t first, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = first; i < end; ++i) sum += v[i] * v[i];
  return std::sqrt(sum);
}

/// (M1), and the limits of acceleration and jerk that follow from it.
void measure(const AxisVector& way, const AxisLimits& limits, PathBlock& block) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    block.direction[i] = way[i] / limits.acceleration[i];
    if (way[i] != 0.0) block.fastest = std::max(block.fastest, std::abs(way[i]) / limits.velocity[i] * 60.0);
  }
  block.length = norm(block.direction, 0, kAxes);
  if (block.length == 0.0) {
    block.free = true, block.length = 1.0;
    return;
  }
  double most = 0.0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    block.direction[i] /= block.length;
    const double share = std::abs(block.direction[i]);
    most = std::max(most, share);
    if (share > 0.0 && limits.jerk[i] < kUnlimited)
      block.limits.jerk = std::min(block.limits.jerk, limits.jerk[i] / limits.acceleration[i] / share);
  }
  block.limits.acceleration = 1.0 / most;
}

/// (M3)
double corner_speed(const PathBlock& before, const PathBlock& block, const MotionOptions& options) {
  if (before.stands || block.stands || before.command.exact_stop || before.free != block.free) return 0.0;
  if (block.free) return kUnlimited;
  if (!options.blend_rotary && (before.turns || block.turns)) return 0.0;
  double turn = 0.0;
  for (std::size_t i = 0; i < kAxes; ++i)
    turn = std::max(turn, std::abs(block.direction[i] - before.direction[i]));
  if (turn == 0.0) return kUnlimited;
  return std::min(options.corner_time / turn, std::sqrt((before.length + block.length) / (2.0 * turn)));
}

AxisVector row(const MachineModel& m, auto of) {
  return {limit_of(of(m.x)), limit_of(of(m.y)), limit_of(of(m.z)), limit_of(of(m.tilt)),
          limit_of(of(m.rotary))};
}

}  // namespace

AxisLimits::AxisLimits(const MachineModel& m)
    : velocity(row(m, [](const auto& axis) { return axis.velocity; })),
      acceleration(row(m, [](const auto& axis) { return axis.acceleration; })),
      jerk(row(m, [](const auto& axis) { return axis.jerk; })) {}

double programmed_seconds(const Block& command, const AxisVector& way, const MotionOptions& options) {
  if (command.op == Op::kDwell) return command.feed;
  if (command.op != Op::kFeed) return 0.0;
  if (command.inverse_time) return 60.0 / command.feed;
  double length = norm(way, 0, kFirstRotary);
  if (options.feed_over_all_axes)
    return std::hypot(length, norm(way, kFirstRotary, kAxes) * options.mm_per_degree) / command.feed * 60.0;
  if (length == 0.0) length = norm(way, kFirstRotary, kAxes);
  return length / command.feed * 60.0;
}

AxisVector axes_of(const Joints& joints) { return {joints.x, joints.y, joints.z, joints.a, joints.c}; }

PathBlock make_path_block(const Block& command, const Joints& from, const PathBlock* before,
                          const AxisLimits& limits, const MotionOptions& options) {
  PathBlock block;
  block.command = command;
  block.stands = command.op == Op::kDwell || command.op == Op::kMCode;
  AxisVector way{};
  if (!block.stands) {
    const AxisVector start = axes_of(from), target = axes_of(command.target);
    for (std::size_t i = 0; i < kAxes; ++i) way[i] = target[i] - start[i];
  }
  const bool still = way == AxisVector{};
  if (still && !block.stands) {
    // A block that goes nowhere takes no time and is no corner.
    if (before != nullptr && !before->stands) {
      block.direction = before->direction;
      block.free = before->free, block.turns = before->turns;
      block.corner = before->command.exact_stop ? 0.0 : kUnlimited;
    }
    block.limits.acceleration = 1.0;
    return block;
  }
  block.turns = way[3] != 0.0 || way[4] != 0.0;
  block.programmed = programmed_seconds(command, way, options);
  measure(way, limits, block);
  if (before != nullptr) block.corner = corner_speed(*before, block, options);
  return block;
}

void apply_overrides(PathBlock& block, int feed_percent, int rapid_percent) {
  const double seconds = block.command.op == Op::kRapid ? block.fastest * 100.0 / rapid_percent
                         : block.stands                 ? block.programmed
                                        : std::max(block.programmed * 100.0 / feed_percent, block.fastest);
  block.limits.speed = seconds > 0.0 ? block.length / seconds : kUnlimited;
}

}  // namespace tiltfeed::sim
