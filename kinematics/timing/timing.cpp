#include "kinematics/timing/timing.h"

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

/// LinuxCNC goes over a corner in X Y Z without a stop while the jump of velocity, within a servo period,
/// takes less than this share of an axis's acceleration; the blocks beside it do without what the jump takes
/// (K10).
constexpr double kKinkShare = 0.1;

// Fewer blocks in a row are not worth a change of the control's mode.
constexpr std::size_t kLeastRun = 8;

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
       double axis_tolerance, Corners corners)
      : moves_(moves),
        exact_(corners == Corners::kExact),
        fixed_(corners == Corners::kFixed),
        blends_rotary_(machine.blends_rotary),
        acceleration_{machine.x.acceleration, machine.y.acceleration, machine.z.acceleration,
                      machine.tilt.acceleration, machine.rotary.acceleration},
        tolerance_{tolerance, tolerance, tolerance, axis_tolerance, axis_tolerance} {
    if (fixed_) blended_ = blends_corners(moves);
  }

  Timing time();

 private:
  Axes way(std::size_t block) const;
  bool turns(std::size_t block) const;
  /// Whether the control goes over from a block to the next at all.
  bool joins(std::size_t block) const;
  /// Whether it does so by the rule of exact stop.
  bool exact(std::size_t block) const {
    return exact_ || (fixed_ && !(blended_[block] && block + 1 < blended_.size() && blended_[block + 1]));
  }
  /// Largest w with which the corner behind a block is passed.
  double corner(std::size_t block) const;
  /// What LinuxCNC puts aside of the acceleration for the kink behind a block; kKinkShare or more: a stop.
  double kink(std::size_t block) const;
  /// Share of the acceleration that is left for the block itself.
  double share(std::size_t block) const;
  /// Largest change of w over a block.
  double gain(std::size_t block) const;
  /// Whether stops are those of LinuxCNC.
  bool counts_periods() const { return exact_ || fixed_ || !blends_rotary_; }
  /// Every stop waits for the end of a servo period.
  void fill_periods();
  void add(std::size_t block, double before, double after, Peaks& peaks);

  const std::vector<JointMove>& moves_;
  bool exact_, fixed_, blends_rotary_;
  std::vector<bool> blended_;  ///< with kFixed
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

bool Pass::turns(std::size_t block) const {
  const Axes d = way(block);
  return d[3] != 0.0 || d[4] != 0.0;
}

bool Pass::joins(std::size_t block) const {
  if (block == 0 || block + 1 >= moves_.size()) return false;
  const JointMove &a = moves_[block], &b = moves_[block + 1];
  if (begins(a) || begins(b)) return false;
  if ((a.kind == MoveKind::kRapid) != (b.kind == MoveKind::kRapid)) return false;
  return (blends_rotary_ && !exact(block)) || !(turns(block) || turns(block + 1));
}

double Pass::kink(std::size_t block) const {
  const Axes before = way(block), after = way(block + 1);
  const double from = std::hypot(before[0], before[1], before[2]),
               to = std::hypot(after[0], after[1], after[2]);
  if (from == 0.0 || to == 0.0) return 0.0;
  const double speed = std::min(from / moves_[block].seconds, to / moves_[block + 1].seconds);
  double most = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    most =
        std::max(most, std::abs(after[i] / to - before[i] / from) * speed / kServoPeriod / acceleration_[i]);
  return most;
}

double Pass::share(std::size_t block) const {
  double most = 0.0;
  for (const std::size_t end : {block - 1, block})
    if (exact(end) && joins(end)) most = std::max(most, std::min(kink(end), kKinkShare));
  return 1.0 - most;
}

double Pass::corner(std::size_t block) const {
  if (!joins(block)) return 0.0;
  if (exact(block)) return kink(block) < kKinkShare ? 1.0 : 0.0;
  const JointMove &a = moves_[block], &b = moves_[block + 1];
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
  return 2.0 * moves_[block].seconds * moves_[block].seconds * least * share(block);
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

void Pass::fill_periods() {
  double since = 0.0;  // the last stop
  for (std::size_t block = 1; block < out_.durations.size(); ++block) {
    since += out_.durations[block];
    if (w_[block] > 0.0) continue;
    const double periods = std::ceil(since / kServoPeriod * (1.0 - 1e-9));
    out_.durations[block] += std::max(0.0, periods * kServoPeriod - since);
    since = 0.0;
  }
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
  if (counts_periods()) fill_periods();
  // In order: the sum has to be the same for any number of threads.
  for (const double seconds : out_.durations) out_.seconds += seconds;
  out_.slowed = peaks.slowed;
  out_.peak_velocity = joints(peaks.velocity);
  for (double Joints::*v : {&Joints::x, &Joints::y, &Joints::z, &Joints::a, &Joints::c})
    out_.peak_velocity.*v *= 60.0;
  out_.peak_acceleration = joints(peaks.acceleration);
  return std::move(out_);
}

}  // namespace

std::vector<bool> blends_corners(const std::vector<JointMove>& moves) {
  const auto still = [&](std::size_t block) {
    if (block == 0 || block >= moves.size() || begins(moves[block])) return false;
    const Joints &from = moves[block - 1].joints, &to = moves[block].joints;
    return from.a == to.a && from.c == to.c;
  };
  std::vector<bool> blends(moves.size(), false);
  std::size_t run = 0;
  for (std::size_t block = 1; block <= moves.size(); ++block) {
    if (block < moves.size() && still(block - 1) && still(block) && still(block + 1)) {
      ++run;
      continue;
    }
    if (run >= kLeastRun) std::fill_n(blends.begin() + static_cast<std::ptrdiff_t>(block - run), run, true);
    run = 0;
  }
  return blends;
}

Timing time_blocks(const std::vector<JointMove>& moves, const MachineModel& machine, double tolerance,
                   double axis_tolerance, Corners corners) {
  return Pass(moves, machine, tolerance, axis_tolerance, corners).time();
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

Timing one_after_the_other(const std::vector<const Timing*>& programs) {
  Timing all = *programs.front();
  for (std::size_t i = 1; i < programs.size(); ++i) {
    const Timing& next = *programs[i];
    all.seconds += next.seconds, all.slowed += next.slowed;
    for (const auto v : {&Joints::x, &Joints::y, &Joints::z, &Joints::a, &Joints::c}) {
      all.peak_velocity.*v = std::max(all.peak_velocity.*v, next.peak_velocity.*v);
      all.peak_acceleration.*v = std::max(all.peak_acceleration.*v, next.peak_acceleration.*v);
    }
    all.durations.insert(all.durations.end(), next.durations.begin(), next.durations.end());
  }
  return all;
}

double rapid_seconds(const MachineModel& machine, const Joints& from, const Joints& to) {
  constexpr double kMinute = 60.0;
  return kMinute *
         std::max({std::abs(to.x - from.x) / machine.x.velocity, std::abs(to.y - from.y) / machine.y.velocity,
                   std::abs(to.z - from.z) / machine.z.velocity,
                   std::abs(to.a - from.a) / machine.tilt.velocity,
                   std::abs(to.c - from.c) / machine.rotary.velocity});
}

}  // namespace tiltfeed
