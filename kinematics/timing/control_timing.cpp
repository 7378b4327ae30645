#include "kinematics/timing/control_timing.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "kinematics/timing/speed_ramp.h"

namespace tiltfeed {
namespace {

constexpr std::size_t kFive = 5;
using Five = std::array<double, kFive>;

// Of so many places in a row one is asked from where the control has to be able to stand; between them the
// speed is taken on a line.
constexpr std::size_t kStopShare = 20;
constexpr std::size_t kMovesAtATime = 1024;

Five five(const Joints& q) { return {q.x, q.y, q.z, q.a, q.c}; }
double stated(double limit) { return limit > 0.0 ? limit : kNoLimit; }

/// A block: its way counts every axis in units of its own acceleration.
struct TimedBlock {
  double way = 0.0, speed = 0.0;  ///< s^2; the programmed one, s
  Five direction{};
  RampLimits limits;
  std::size_t move = 0;
  bool begins = false;  ///< the axes stand before it
};

class ControlTiming {
 public:
  ControlTiming(const std::vector<JointMove>& moves, const MachineModel& m, const ControlPace& pace)
      : moves_(moves),
        pace_(pace),
        acceleration_{stated(m.x.acceleration), stated(m.y.acceleration), stated(m.z.acceleration),
                      stated(m.tilt.acceleration), stated(m.rotary.acceleration)},
        jerk_{stated(m.x.jerk), stated(m.y.jerk), stated(m.z.jerk), stated(m.tilt.jerk),
              stated(m.rotary.jerk)} {}

  Timing time() {
    out_.durations.assign(moves_.size(), 0.0);
    take_blocks();
    find_corners();
    brake();
    look_ahead();
    for (std::size_t k = 0; k < blocks_.size(); ++k)
      end_[k + 1] = std::min(end_[k + 1], k == 0 || blocks_[k].begins
                                              ? reached_speed(0.0, blocks_[k].way, blocks_[k].limits)
                                              : reached_speed(end_[k], blocks_[k].way, blocks_[k].limits));
    add_up();
    return std::move(out_);
  }

 private:
  double seconds(const JointMove& move) const {
    return move.kind == MoveKind::kRapid ? move.seconds : std::max(move.seconds, pace_.least_seconds);
  }

  void take_blocks() {
    bool begins = true;
    for (std::size_t i = 1; i < moves_.size(); ++i) {
      // An operation begins with it: how the tool came there is not known, and takes no time here.
      if (!(moves_[i].seconds > 0.0)) {
        begins = true;
        continue;
      }
      TimedBlock block;
      const Five from = five(moves_[i - 1].joints), to = five(moves_[i].joints);
      double square = 0.0;
      for (std::size_t k = 0; k < kFive; ++k) {
        block.direction[k] = (to[k] - from[k]) / acceleration_[k];
        square += block.direction[k] * block.direction[k];
      }
      block.way = std::sqrt(square);
      if (!(block.way > 0.0)) {
        // No axis with a limit moves.
        if (from != to) out_.durations[i] = seconds(moves_[i]);
        continue;
      }
      double most = 0.0;
      for (std::size_t k = 0; k < kFive; ++k) {
        block.direction[k] /= block.way;
        const double share = std::abs(block.direction[k]);
        most = std::max(most, share);
        if (share > 0.0)
          block.limits.jerk = std::min(block.limits.jerk, jerk_[k] / (acceleration_[k] * share));
      }
      block.limits.acceleration = 1.0 / most;
      block.speed = block.way / seconds(moves_[i]);
      block.move = i, block.begins = std::exchange(begins, false);
      blocks_.push_back(block);
    }
  }

  /// Of every block's end the highest speed that it, the next one and the corner allow.
  void find_corners() {
    corner_.assign(blocks_.size() + 1, 0.0);
    for (std::size_t k = 0; k + 1 < blocks_.size(); ++k) {
      const TimedBlock &a = blocks_[k], &b = blocks_[k + 1];
      if (b.begins) continue;
      double turn = 0.0;
      for (std::size_t i = 0; i < kFive; ++i)
        turn = std::max(turn, std::abs(b.direction[i] - a.direction[i]));
      double speed = std::min(a.speed, b.speed);
      if (turn > 0.0)
        speed = std::min({speed, pace_.corner_time / turn, std::sqrt((a.way + b.way) / (2.0 * turn))});
      corner_[k + 1] = speed;
    }
  }

  /// From the end of block `last`, where the axes stand, back to the end of block `first`; of every block's
  /// end tell(k, speed), which ends it with false.
  template <class Tell>
  void brake_back(std::size_t last, std::size_t first, const Tell& tell) const {
    double speed = 0.0;
    for (std::size_t k = last; k > first; --k) {
      speed = std::min(corner_[k], reached_speed(speed, blocks_[k].way, blocks_[k].limits));
      if (blocks_[k].begins) speed = 0.0;
      if (!tell(k, speed)) return;
    }
  }

  /// With all blocks known. end_[k]: behind block k - 1.
  void brake() {
    end_.assign(blocks_.size() + 1, 0.0);
    if (blocks_.empty()) return;
    brake_back(blocks_.size() - 1, 0, [&](std::size_t k, double speed) {
      end_[k] = speed;
      return true;
    });
  }

  /// Where the control knows less: the axes must be able to stand at the end of what it knows.
  void look_ahead() {
    const std::size_t window = pace_.look_ahead;
    if (window == 0 || window >= blocks_.size()) return;
    const std::vector<double> all = end_;
    const std::size_t apart = std::max<std::size_t>(1, window / kStopShare);
    // Stops behind the blocks apart - 1, 2 apart - 1 and so on. Of a block's end k those two count between
    // which the end of what is known lies.
    const std::size_t stops = (blocks_.size() - 1) / apart + 2;
    std::vector<std::vector<double>> speeds(stops);
    tbb::parallel_for(std::size_t{1}, stops, [&](std::size_t s) {
      const std::size_t last = s * apart - 1;
      if (last >= blocks_.size()) return;
      const std::size_t first = last > window + apart ? last - window - apart : 0;
      std::vector<double>& found = speeds[s];
      brake_back(last, first, [&](std::size_t k, double speed) {
        found.push_back(speed);
        // From here on it is the same with all blocks known.
        return speed < all[k];
      });
    });
    const auto from_stop = [&](std::size_t s, std::size_t k) {
      const std::size_t last = s * apart - 1;
      if (s == 0 || k > last) return 0.0;
      if (last >= blocks_.size() || last - k >= speeds[s].size()) return all[k];
      return speeds[s][last - k];
    };
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(1, blocks_.size(), kMovesAtATime), [&](const auto& range) {
          for (std::size_t k = range.begin(); k < range.end(); ++k) {
            // While block k - 1 runs, those up to this one are known.
            const std::size_t last = k - 1 + window - 1;
            if (last + 1 >= blocks_.size()) continue;
            const std::size_t s = (last + 1) / apart;
            const double low = from_stop(s, k), high = from_stop(s + 1, k);
            const double share = static_cast<double>((last + 1) % apart) / static_cast<double>(apart);
            end_[k] = std::min(all[k], low + (high - low) * share);
          }
        });
  }

  void add_up() {
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      const TimedBlock& b = blocks_[k];
      const double from = b.begins ? 0.0 : end_[k], to = end_[k + 1];
      const double peak = peak_speed(from, to, b.way, b.speed, b.limits);
      const double up = ramp_way(from, peak, b.limits), down = ramp_way(peak, to, b.limits);
      double seconds = ramp_time(peak - from, b.limits) + ramp_time(peak - to, b.limits);
      if (peak > 0.0) seconds += std::max(0.0, b.way - up - down) / peak;
      out_.durations[b.move] = seconds;
      if (seconds > b.way / b.speed * (1.0 + kSlowed)) ++out_.slowed;
      const double change = peak - std::min(from, to);
      const double acceleration =
          change > 0.0 ? std::min(b.limits.acceleration, std::sqrt(b.limits.jerk * change)) : 0.0;
      raise(b, peak, acceleration);
    }
    // In order: the sum has to be the same for any number of threads.
    for (const double one : out_.durations) out_.seconds += one;
  }

  void raise(const TimedBlock& b, double speed, double acceleration) {
    constexpr double Joints::*kPlaces[] = {&Joints::x, &Joints::y, &Joints::z, &Joints::a, &Joints::c};
    for (std::size_t i = 0; i < kFive; ++i) {
      if (b.direction[i] == 0.0) continue;
      const double share = std::abs(b.direction[i]) * acceleration_[i];
      double &v = out_.peak_velocity.*kPlaces[i], &a = out_.peak_acceleration.*kPlaces[i];
      v = std::max(v, share * speed * 60.0), a = std::max(a, share * acceleration);
    }
  }

  const std::vector<JointMove>& moves_;
  const ControlPace& pace_;
  const Five acceleration_, jerk_;
  std::vector<TimedBlock> blocks_;
  std::vector<double> corner_, end_;
  Timing out_;
};

}  // namespace

Timing time_on_control(const std::vector<JointMove>& moves, const MachineModel& machine,
                       const ControlPace& pace) {
  return ControlTiming(moves, machine, pace).time();
}

}  // namespace tiltfeed
