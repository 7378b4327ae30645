#include "kinematics/timing/tcp_path.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "kinematics/basics/decimal.h"

namespace tiltfeed {
namespace {

// Blocks that are joined into one at most: bounds the work, and the block is long by then.
constexpr std::size_t kMostJoined = 32;

// Places in each block where the axis is compared.
constexpr std::array<double, 3> kSamples{1.0 / 3.0, 2.0 / 3.0, 1.0};

Joints between(const Joints& p, const Joints& q, double f) {
  return {p.x + f * (q.x - p.x), p.y + f * (q.y - p.y), p.z + f * (q.z - p.z), p.a + f * (q.a - p.a),
          p.c + f * (q.c - p.c)};
}

class Joiner {
 public:
  Joiner(const JointPath& path, const MachineModel& machine, const Setup& setup, const TcpOptions& options)
      : path_(path), machine_(machine), setup_(setup), options_(options), poses_(path.moves.size()) {
    tbb::parallel_for(std::size_t{0}, poses_.size(),
                      [&](std::size_t i) { poses_[i] = forward(machine, setup, path.moves[i].joints); });
  }

  JointPath join();

 private:
  bool fits(std::size_t from, std::size_t to) const;
  double fraction(std::size_t from, std::size_t to, Point<Part> tip, double passed) const;
  Joints words(std::size_t index) const;

  const JointPath& path_;
  const MachineModel& machine_;
  const Setup& setup_;
  const TcpOptions& options_;
  std::vector<Pose> poses_;
};

/// How far a tip is on the straight way from one block's end to another's; `passed`: the share of the time,
/// for ways no longer than what the words can say.
double Joiner::fraction(std::size_t from, std::size_t to, Point<Part> tip, double passed) const {
  const Vec3 way = poses_[to].tip - poses_[from].tip;
  const double square = squared_length(way), least = 10.0 / decimal_scale(options_.linear_decimals);
  if (square <= least * least) return passed;
  return std::clamp(dot(tip - poses_[from].tip, way) / square, 0.0, 1.0);
}

/// One block may lead from the end of block `from` to that of block `to`: its axis is that of the blocks
/// between wherever the tip is.
bool Joiner::fits(std::size_t from, std::size_t to) const {
  const Joints &p = path_.moves[from].joints, &q = path_.moves[to].joints;
  if (std::abs(q.a - p.a) >= 180.0 || std::abs(q.c - p.c) >= 180.0) return false;
  if (path_.moves[from + 1].kind != path_.moves[to].kind) return false;
  const double allowed = Angle::from_degrees(options_.axis_tolerance).radians();
  const double strays =
      options_.tip_tolerance * (path_.moves[to].kind == MoveKind::kRapid ? kRapidToleranceFactor : 1.0);
  double whole = 0.0, before = 0.0;
  for (std::size_t i = from + 1; i <= to; ++i) whole += path_.moves[i].seconds;
  for (std::size_t i = from + 1; i <= to; before += path_.moves[i++].seconds) {
    for (const double s : kSamples) {
      const Pose pose =
          forward(machine_, setup_, between(path_.moves[i - 1].joints, path_.moves[i].joints, s));
      if (distance_to_segment(pose.tip, poses_[from].tip, poses_[to].tip) > strays) return false;
      const double f = fraction(from, to, pose.tip, (before + s * path_.moves[i].seconds) / whole);
      if (angle_between(forward(machine_, setup_, between(p, q, f)).axis, pose.axis) > allowed) return false;
    }
  }
  return true;
}

Joints Joiner::words(std::size_t index) const {
  const Vec3 tip = setup_.fixture * from_origin(poses_[index].tip);
  const Joints& q = path_.moves[index].joints;
  return {round_decimal(tip.x, options_.linear_decimals), round_decimal(tip.y, options_.linear_decimals),
          round_decimal(tip.z, options_.linear_decimals), q.a, q.c};
}

JointPath Joiner::join() {
  JointPath out;
  out.report = path_.report;
  const std::vector<JointMove>& moves = path_.moves;
  out.moves.reserve(moves.size());
  if (moves.empty()) return out;
  out.moves.push_back({words(0), moves[0].seconds, moves[0].kind, moves[0].move});
  out.ends.push_back(0);
  double seconds = 0.0;
  for (std::size_t from = 0; from + 1 < moves.size();) {
    std::size_t to = from + 1;
    while (to + 1 < moves.size() && moves[to + 1].move == moves[to].move &&
           moves[to + 1].speed == moves[to].speed && to + 1 - from <= kMostJoined && fits(from, to + 1))
      ++to;
    for (std::size_t i = from + 1; i <= to; ++i) seconds += moves[i].seconds;
    const Joints next = words(to);
    if (next != out.moves.back().joints) {
      out.moves.push_back({next, seconds, moves[to].kind, moves[to].move, moves[to].speed});
      out.ends.push_back(static_cast<std::uint32_t>(to));
      seconds = 0.0;
    }
    from = to;
  }
  return out;
}

}  // namespace

JointPath words_under_tcp(const JointPath& path, const MachineModel& machine, const Setup& setup,
                          const TcpOptions& options) {
  return Joiner(path, machine, setup, options).join();
}

Pose pose_under_tcp(const MachineModel& machine, const Setup& setup, const Joints& words) {
  const Vec3 tip = transposed(setup.fixture) * Vec3{words.x, words.y, words.z};
  return {{tip.x, tip.y, tip.z}, forward(machine, setup, words).axis};
}

}  // namespace tiltfeed
