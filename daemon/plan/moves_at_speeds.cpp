#include "daemon/plan/moves_at_speeds.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/decimal.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed::daemon {
namespace {

// A piece of a cut lasts this long at least, s: a look-ahead of some hundred blocks is some seconds then.
constexpr double kShortestPiece = 0.01;

/// Up to `share` of a move at one speed.
struct SpeedShare {
  double share = 1.0, speed = 1.0;
};

class SpeedCutter {
 public:
  SpeedCutter(const std::vector<JointMove>& moves, const std::vector<SpeedStep>& steps,
              const SpeedWords& words)
      : moves_(moves), steps_(steps), words_(words) {}

  std::vector<JointMove> run() {
    if (!moves_.empty()) out_.push_back(moves_.front());
    for (std::size_t i = 1; i < moves_.size(); ++i) {
      begin_ = end_, end_ += moves_[i].seconds;
      if (moves_[i].kind == MoveKind::kCut && moves_[i].seconds > 0.0)
        cut_up(i);
      else
        out_.push_back(moves_[i]);
    }
    return std::move(out_);
  }

 private:
  /// The steps that the move lies in. Too short pieces take the lower speed of both.
  std::vector<SpeedShare> shares(const JointMove& move) {
    std::vector<SpeedShare> all;
    while (step_ < steps_.size() && steps_[step_].end <= begin_) ++step_;
    const double rounding = 1e-6 * move.seconds;
    for (std::size_t k = step_;; ++k) {
      const bool last = k >= steps_.size() || steps_[k].end >= end_ - rounding;
      const double speed = k < steps_.size() ? steps_[k].speed : 1.0;
      const double share = last ? 1.0 : (steps_[k].end - begin_) / move.seconds;
      if (!all.empty() && all.back().speed == speed)
        all.back().share = share;
      else if (share * move.seconds > rounding)
        all.push_back({share, speed});
      if (last) break;
    }
    const double least = std::max(kShortestPiece, words_.least_seconds);
    for (std::size_t k = 0; all.size() > 1 && k < all.size();) {
      const double from = k > 0 ? all[k - 1].share : 0.0;
      if ((all[k].share - from) * move.seconds / all[k].speed >= least) {
        ++k;
        continue;
      }
      const std::size_t first = k + 1 < all.size() ? k : k - 1;
      all[first + 1].speed = std::min(all[first].speed, all[first + 1].speed);
      all.erase(all.begin() + static_cast<std::ptrdiff_t>(first));
      k = 0;
    }
    return all;
  }

  Joints between_words(const Joints& from, const Joints& to, double f) const {
    const auto mix = [&](double a, double b, int decimals) {
      return a == b ? a : round_decimal(a + (b - a) * f, decimals);
    };
    return {mix(from.x, to.x, words_.linear_decimals), mix(from.y, to.y, words_.linear_decimals),
            mix(from.z, to.z, words_.linear_decimals), mix(from.a, to.a, words_.rotary_decimals),
            mix(from.c, to.c, words_.rotary_decimals)};
  }

  void cut_up(std::size_t index) {
    const JointMove& move = moves_[index];
    const Joints &from = moves_[index - 1].joints, &to = move.joints;
    const double own_least = rapid_seconds(words_.machine, from, to);
    double passed = 0.0;
    for (const SpeedShare& piece : shares(move)) {
      const double share = piece.share - passed, own = move.seconds * share;
      // At the speed of its slowest axis no move gets quicker, whatever its share.
      double seconds = piece.speed == 1.0 ? own : std::max(own / piece.speed, own_least * share);
      if (piece.speed > 1.0) seconds = std::max(seconds, std::min(own, stop_seconds(from, to, share)));
      if (piece.speed > 1.0) seconds = std::max(seconds, std::min(own, words_.least_seconds));
      const Joints end = piece.share >= 1.0 ? to : between_words(from, to, piece.share);
      passed = piece.share;
      if (end == out_.back().joints) {
        carried_ += seconds;
        continue;
      }
      out_.push_back({end, seconds + carried_, move.kind, move.move, piece.speed});
      carried_ = 0.0;
    }
  }

  /// (K10) What a control that stops at rotary blocks needs.
  double stop_seconds(const Joints& from, const Joints& to, double share) const {
    const MachineModel& m = words_.machine;
    if (m.blends_rotary || (to.a == from.a && to.c == from.c)) return 0.0;
    const double harshest =
        std::max({std::abs(to.x - from.x) / m.x.acceleration, std::abs(to.y - from.y) / m.y.acceleration,
                  std::abs(to.z - from.z) / m.z.acceleration, std::abs(to.a - from.a) / m.tilt.acceleration,
                  std::abs(to.c - from.c) / m.rotary.acceleration});
    return std::sqrt(2.0 * harshest * share);
  }

  const std::vector<JointMove>& moves_;
  const std::vector<SpeedStep>& steps_;
  const SpeedWords& words_;
  std::size_t step_ = 0;
  double begin_ = 0.0, end_ = 0.0, carried_ = 0.0;
  std::vector<JointMove> out_;
};

}  // namespace

std::vector<JointMove> at_speeds(const std::vector<JointMove>& moves, const std::vector<SpeedStep>& steps,
                                 const SpeedWords& words) {
  return SpeedCutter(moves, steps, words).run();
}

}  // namespace tiltfeed::daemon
