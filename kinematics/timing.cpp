#include "kinematics/timing.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tiltfeed {
namespace {

constexpr std::size_t kAxes = 5;
using Axes = std::array<double, kAxes>;

Axes axes(const Joints& q) { return {q.x, q.y, q.z, q.a, q.c}; }
Joints joints(const Axes& q) { return {q[0], q[1], q[2], q[3], q[4]}; }

/// An operation begins with it: how the tool came there is not known, and takes no time here.
bool begins(const JointMove& move) { return !(move.seconds > 0.0); }

/// Of some blocks: per s and per s^2.
struct Peaks {
  Axes velocity{}, acceleration{};
  std::uint64_t slowed = 0;
  Peaks with(const Peaks& other) const {
    Peaks both = *this;
    for (std::size_t i = 0; i < kAxes; ++i) {
      both.velocity[i] = std::max(velocity[i], other.velocity[i]);
      both.acceleration[i] = std::max(acceleration[i], other.acceleration[i]);
    }
    both.slowed += other.slowed;
    return both;
  }
};

/// One pass over a program. `w` is the square of the speed as a share of the programmed one; all limits of
/// acceleration are linear in it.
class Pass {
 public:
  Pass(const std::vector<JointMove>& moves, const MachineModel& machine, double tolerance,
       double axis_tolerance)
      : moves_(moves),
        acceleration_{machine.x.acceleration, machine.y.acceleration, machine.z.acceleration,
                      machine.tilt.acceleration, machine.rotary.acceleration},
        tolerance_{tolerance, tolerance, tolerance, axis_tolerance, axis_tolerance} {}

  Timing time();

 private:
  Axes way(std::size_t block) const;
  /// Largest w with which the corner behind a block is passed.
  double corner(std::size_t block) const;
  /// Largest change of w over a block.
  double gain(std::size_t block) const;
  void add(std::size_t block, double before, double after, Peaks& peaks);

  const std::vector<JointMove>& moves_;
  Axes acceleration_, tolerance_;
  std::vector<double> w_, gain_;  ///< behind each block; over each block
  Timing out_;
};

Axes Pass::way(std::size_t block) const {
  const Axes from = axes(moves_[block - 1].joints), to = axes(moves_[block].joints);
  Axes d;
  for (std::size_t i = 0; i < kAxes; ++i) d[i] = to[i] - from[i];
  return d;
}

double Pass::corner(std::size_t block) const {
  if (block + 1 >= moves_.size()) return 0.0;
  const JointMove &a = moves_[block], &b = moves_[block + 1];
  if (begins(a) || begins(b)) return 0.0;
  if ((a.kind == MoveKind::kRapid) != (b.kind == MoveKind::kRapid)) return 0.0;
  const Axes before = way(block), after = way(block + 1);
  // The velocity turns over a time `window` at the programmed speed: a bow of |dv| window / 8 off the corner.
  double window = (a.seconds + b.seconds) / 2.0;
  Axes change;
  for (std::size_t i = 0; i < kAxes; ++i) {
    change[i] = std::abs(after[i] / b.seconds - before[i] / a.seconds);
    if (change[i] * window > 8.0 * tolerance_[i]) window = 8.0 * tolerance_[i] / change[i];
  }
  double w = 1.0;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (change[i] * w > acceleration_[i] * window) w = acceleration_[i] * window / change[i];
  return w;
}

double Pass::gain(std::size_t block) const {
  if (begins(moves_[block])) return 0.0;
  const Axes d = way(block);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kAxes; ++i)
    if (d[i] != 0.0) least = std::min(least, acceleration_[i] / std::abs(d[i]));
  return 2.0 * moves_[block].seconds * moves_[block].seconds * least;
}

/// The block from the speed `before` to `after` as a trapezoid.
void Pass::add(std::size_t block, double before, double after, Peaks& peaks) {
  if (begins(moves_[block])) return;
  const double g = gain_[block], programmed = moves_[block].seconds;
  const double top = std::min(1.0, (before + after + g) / 2.0);
  const double v0 = std::sqrt(before), v1 = std::sqrt(after), v = std::sqrt(top);
  const double up = std::max(0.0, (top - before) / g), down = std::max(0.0, (top - after) / g);
  const double rest = std::max(0.0, 1.0 - up - down);
  const double seconds = programmed * (2.0 * up / (v0 + v) + 2.0 * down / (v1 + v) + rest / v);
  const Axes d = way(block);
  const double velocity = v / programmed;
  const double acceleration = up > 0.0 || down > 0.0 ? g / (2.0 * programmed * programmed) : 0.0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    peaks.velocity[i] = std::max(peaks.velocity[i], std::abs(d[i]) * velocity);
    peaks.acceleration[i] = std::max(peaks.acceleration[i], std::abs(d[i]) * acceleration);
  }
  out_.durations[block] = seconds;
  if (seconds > programmed * (1.0 + kSlowed)) ++peaks.slowed;
}

Timing Pass::time() {
  const std::size_t count = moves_.size();
  w_.assign(count, 0.0);
  gain_.assign(count, 0.0);
  out_.durations.assign(count, 0.0);
  tbb::parallel_for(std::size_t{1}, std::max<std::size_t>(count, 1), [&](std::size_t block) {
    w_[block] = corner(block);
    gain_[block] = gain(block);
  });
  for (std::size_t block = 1; block < count; ++block)
    w_[block] = std::min(w_[block], w_[block - 1] + gain_[block]);
  for (std::size_t block = count; block-- > 1;)
    w_[block - 1] = std::min(w_[block - 1], w_[block] + gain_[block]);
  const Peaks peaks = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(1, std::max<std::size_t>(count, 1)), Peaks{},
      [&](const tbb::blocked_range<std::size_t>& range, Peaks part) {
        for (std::size_t block = range.begin(); block < range.end(); ++block)
          add(block, w_[block - 1], w_[block], part);
        return part;
      },
      [](const Peaks& a, const Peaks& b) { return a.with(b); });
  // In order: the sum has to be the same for any number of threads.
  for (const double seconds : out_.durations) out_.seconds += seconds;
  out_.slowed = peaks.slowed;
  out_.peak_velocity = joints(peaks.velocity);
  for (double Joints::*v : {&Joints::x, &Joints::y, &Joints::z, &Joints::a, &Joints::c})
    out_.peak_velocity.*v *= 60.0;
  out_.peak_acceleration = joints(peaks.acceleration);
  return std::move(out_);
}

/// The programmed times as they are.
Timing as_programmed(const std::vector<JointMove>& moves) {
  Timing out;
  Axes velocity{}, acceleration{};
  for (std::size_t block = 0; block < moves.size(); ++block) {
    const double seconds = moves[block].seconds;
    out.seconds += seconds;
    out.durations.push_back(seconds);
    if (block == 0 || begins(moves[block])) continue;
    const Axes from = axes(moves[block - 1].joints), to = axes(moves[block].joints);
    for (std::size_t i = 0; i < kAxes; ++i) {
      velocity[i] = std::max(velocity[i], 60.0 * std::abs(to[i] - from[i]) / seconds);
      // Half of the block to reach twice its mean speed, half to leave it.
      acceleration[i] = std::max(acceleration[i], 2.0 * std::abs(to[i] - from[i]) / (seconds * seconds));
    }
  }
  out.peak_velocity = joints(velocity);
  out.peak_acceleration = joints(acceleration);
  return out;
}

}  // namespace

Timing time_blocks(const std::vector<JointMove>& moves, const MachineModel& machine, double tolerance,
                   double axis_tolerance) {
  if (!machine.blends_rotary) return as_programmed(moves);
  return Pass(moves, machine, tolerance, axis_tolerance).time();
}

Starvation starvation(const std::vector<double>& durations, const LinkRate& link) {
  const double send = link.bytes_per_block / link.bytes_per_s;
  // What waits in the control when the window begins.
  const double ahead = std::floor(link.buffer_bytes / link.bytes_per_block) * send;
  Starvation worst;
  double behind = 0.0, seconds = 0.0;
  std::size_t first = 0;
  for (std::size_t block = 0; block < durations.size(); ++block) {
    if (behind == 0.0) {
      first = block;
      seconds = 0.0;
    }
    seconds += durations[block];
    behind = std::max(0.0, behind + send - durations[block]);
    if (behind - ahead <= worst.waits) continue;
    const std::size_t count = block + 1 - first;
    worst = {behind - ahead, first, count, seconds,
             (static_cast<double>(count) * link.bytes_per_block - link.buffer_bytes) / seconds};
  }
  return worst;
}

}  // namespace tiltfeed
