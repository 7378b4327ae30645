#include "sim/path_check/executed.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/motion/forward.h"
#include "sim/motion/path_block.h"

namespace tiltfeed::sim {
namespace {

// Poses that the length of a block's motion is estimated from; with a C turn under 180 degrees the chords
// of quarters fall short of the arc by at most 2.6 percent, which kArcExcess makes good.
constexpr int kQuarters = 4;
constexpr double kArcExcess = 1.03;
// A machine that turns C by thousands of degrees in one block would need more; such a block is wrong anyway
// and fails against the planned path.
constexpr std::uint32_t kMaxSamples = 100000;

Joints between(const Joints& from, const Joints& to, double f) {
  const auto mix = [f](double a, double b) { return a + (b - a) * f; };
  return {mix(from.x, to.x), mix(from.y, to.y), mix(from.z, to.z), mix(from.a, to.a), mix(from.c, to.c)};
}

}  // namespace

std::vector<ExecutedBlock> executed_blocks(const std::vector<TraceRow>& trace) {
  std::vector<ExecutedBlock> blocks;
  bool started = false;
  std::size_t before = 0;
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const Op op = trace[i].command.op;
    if (op != Op::kRapid && op != Op::kFeed) continue;
    if (started) blocks.push_back({before, i});
    started = true, before = i;
  }
  return blocks;
}

AxisPeaks axis_peaks(const std::vector<TraceRow>& trace) {
  AxisPeaks peaks;
  for (const ExecutedBlock& block : executed_blocks(trace)) {
    const TraceRow& row = trace[block.to];
    const AxisVector from = axes_of(trace[block.from].command.target), to = axes_of(row.command.target);
    for (std::size_t i = 0; i < to.size(); ++i) {
      const double way = std::abs(to[i] - from[i]);
      peaks.speed[i] = std::max(peaks.speed[i], way * row.peak_rate * 60.0);
      peaks.acceleration[i] = std::max(peaks.acceleration[i], way * row.peak_acceleration);
    }
  }
  return peaks;
}

std::uint32_t sample_block(const MachineModel& machine, const Setup& setup, const Joints& from,
                           const Joints& to, const Sampling& sampling, std::vector<Pose>& poses) {
  std::array<Pose, kQuarters + 1> rough;
  double tip_way = 0.0, shank_way = 0.0;
  for (int i = 0; i <= kQuarters; ++i) {
    rough[i] = forward_by_frames(machine, setup, between(from, to, static_cast<double>(i) / kQuarters));
    if (i == 0) continue;
    const Pose &p = rough[i - 1], &q = rough[i];
    tip_way += distance(p.tip, q.tip);
    shank_way += length(q.tip + q.axis * sampling.shank_length - (p.tip + p.axis * sampling.shank_length));
  }
  const double wanted = std::ceil(std::max(tip_way, shank_way) * kArcExcess / sampling.max_step);
  const auto count =
      static_cast<std::uint32_t>(std::clamp<double>(wanted, std::max(1, sampling.per_block), kMaxSamples));
  for (std::uint32_t i = 1; i < count; ++i)
    poses.push_back(forward_by_frames(machine, setup, between(from, to, static_cast<double>(i) / count)));
  poses.push_back(rough[kQuarters]);
  return count;
}

}  // namespace tiltfeed::sim
