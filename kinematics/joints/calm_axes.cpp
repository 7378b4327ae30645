#include "kinematics/joints/calm_axes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "kinematics/joints/even_turn.h"
#include "kinematics/joints/path_splice.h"
#include "kinematics/machine/sweep.h"

namespace tiltfeed {
namespace {

/// The axis is chosen at places so far apart in time at the programmed feed, s, and turns evenly between.
constexpr double kNodeSeconds = 0.02;
/// Between them the planned axis strays by no more than this share of the cone from its even turn.
constexpr double kStrays = 0.25;
/// A move without a way takes so long at least, s.
constexpr double kLeastSeconds = 1e-4;
/// Where the tool is not clear the cone about the nodes there is halved, so often; then it is closed.
constexpr int kCalmHalvings = 3;
/// After so many rounds it is closed at once, and the axes elsewhere stay as they are.
constexpr int kMostCalmRounds = 12;
/// So many cones from the table's axis, at either end of it, the axis is kept: turns say little there.
constexpr double kPoleCones = 2.0;
/// A point that leans by less (rad) does not lean.
constexpr double kNoCalmLean = 1e-9;
/// Sine of the angle from the table's axis within which it is taken to have no turn.
constexpr double kOnCalmPole = 1e-9;
/// The bow of the ball's centre in a move that turns by d is r d^2 / 8; with some room.
constexpr double kBow = 8.0 * 0.8;

/// Moves first + 1 to last, all cuts.
struct CutRun {
  std::size_t first = 0, last = 0;
};

std::vector<CutRun> runs_of(const ToolPath& path) {
  std::vector<CutRun> runs;
  for (std::size_t i = 1; i < path.moves.size(); ++i) {
    if (path.moves[i].kind != MoveKind::kCut) continue;
    if (!runs.empty() && runs.back().last == i - 1)
      runs.back().last = i;
    else
      runs.push_back({i - 1, i});
  }
  return runs;
}

/// A point of the path or between two of them.
struct CalmStation {
  Move move;
  double seconds = 0.0;  ///< since the run began, at the programmed feed
  AxisAngles axis;       ///< of the move's pose
  bool is_original = false;
};

struct Calmed {
  std::vector<Move> moves;             ///< instead of first + 1 to last
  std::vector<std::uint8_t> original;  ///< each of them is a point of the path
  std::size_t points = 0, refused = 0;
  double largest = 0.0;
};

/// How far it is, told on the thread that made this, whichever threads check moves.
class CalmProgress {
 public:
  CalmProgress(const StageProgress& told, const std::vector<CutRun>& runs) : told_(told) {
    for (const CutRun& run : runs) total_ += run.last - run.first;
  }
  /// Before a move is checked; `first`: one of the path, for the first time. False: cancelled.
  bool go_on(bool first) {
    if (first) done_.fetch_add(1, std::memory_order_relaxed);
    if (told_ && std::this_thread::get_id() == teller_ && ++asked_ % kToldEvery == 0) tell();
    return !cancelled();
  }
  void tell() {
    if (told_ && !told_(total_ > 0 ? static_cast<double>(done_) / static_cast<double>(total_) : 1.0))
      cancelled_ = true;
  }
  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kToldEvery = 64;

  const StageProgress& told_;
  const std::thread::id teller_ = std::this_thread::get_id();
  std::size_t total_ = 0, asked_ = 0;  ///< asked_: on the teller alone
  std::atomic<std::size_t> done_{0};
  std::atomic<bool> cancelled_{false};
};

double off_pole(const AxisAngles& axis) { return std::min(axis.tilt, kPi - axis.tilt); }

class Calmer {
 public:
  Calmer(const ToolPath& path, Vec3 up, const CalmOptions& options, const MoveCheck& clear,
         CalmProgress& progress)
      : path_(path),
        clear_(clear),
        progress_(progress),
        up_(up),
        x_(normalized(cross(up, std::abs(up.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}))),
        y_(cross(up, x_)),
        cone_(options.cone.radians()),
        radius_(path.tool.corner_radius),
        longest_turn_(radius_ > 0.0 ? std::sqrt(kBow * options.tolerance / radius_) : kPi) {}

  /// Not to be used where it was cancelled.
  Calmed calm(const CutRun& run) const;

 private:
  std::vector<CalmStation> stations(const CutRun& run) const;
  std::vector<std::size_t> nodes(const std::vector<CalmStation>& stations) const;
  AxisAngles angles(Vec3 axis, double before) const;
  Vec3 axis(const AxisAngles& angles) const;
  Point<Part> centre(const Pose& pose) const { return pose.tip + pose.axis * radius_; }
  Pose stand(Point<Part> centre, Vec3 axis) const { return {centre - axis * radius_, axis}; }

  const ToolPath& path_;
  const MoveCheck& clear_;
  CalmProgress& progress_;
  Vec3 up_, x_, y_;
  double cone_, radius_, longest_turn_;
};

/// The axis's angles, turned by less than half a turn from `before`.
AxisAngles Calmer::angles(Vec3 axis, double before) const {
  const double x = dot(axis, x_), y = dot(axis, y_), z = dot(axis, up_);
  const double tilt = std::atan2(std::hypot(x, y), z);
  const double turn = std::hypot(x, y) > kOnCalmPole ? std::atan2(y, x) : before;
  return {tilt, before + std::remainder(turn - before, 2.0 * kPi)};
}

Vec3 Calmer::axis(const AxisAngles& a) const {
  return normalized(up_ * std::cos(a.tilt) +
                    (x_ * std::cos(a.turn) + y_ * std::sin(a.turn)) * std::sin(a.tilt));
}

std::vector<CalmStation> Calmer::stations(const CutRun& run) const {
  std::vector<CalmStation> out{
      {path_.moves[run.first], 0.0, angles(path_.moves[run.first].pose.axis, 0.0), true}};
  for (std::size_t i = run.first + 1; i <= run.last; ++i) {
    const Pose &a = path_.moves[i - 1].pose, &b = path_.moves[i].pose;
    const double seconds = std::max(kLeastSeconds, distance(a.tip, b.tip) / feed_of(path_, i).mm_per_s());
    const int pieces = std::max(1, static_cast<int>(std::ceil(seconds / kNodeSeconds - 1e-9)));
    const Point<Part> from = centre(a), to = centre(b);
    const double before = out.back().seconds, angle = angle_between(a.axis, b.axis);
    for (int k = 1; k <= pieces; ++k) {
      const double f = static_cast<double>(k) / pieces;
      CalmStation next{path_.moves[i], before + f * seconds, {}, k == pieces};
      if (k < pieces)
        next.move.pose = stand(from + (to - from) * f, angle > 0.0 ? slerp(a.axis, b.axis, f) : a.axis);
      next.axis = angles(next.move.pose.axis, out.back().axis.turn);
      out.push_back(next);
    }
  }
  return out;
}

/// Between two of them the planned axes are near the even way from the one to the other.
std::vector<std::size_t> Calmer::nodes(const std::vector<CalmStation>& s) const {
  std::vector<std::size_t> out{0};
  const auto even = [&](std::size_t a, std::size_t b) {
    for (std::size_t k = a + 1; k < b; ++k) {
      const double f = (s[k].seconds - s[a].seconds) / (s[b].seconds - s[a].seconds);
      if (angle_between(s[k].axis, on_way(s[a].axis, s[b].axis, f)) > kStrays * cone_) return false;
    }
    return true;
  };
  for (std::size_t i = 1; i < s.size(); ++i) {
    const bool last = i + 1 == s.size();
    if (last || s[i + 1].seconds - s[out.back()].seconds > kNodeSeconds || !even(out.back(), i + 1))
      out.push_back(i);
  }
  return out;
}

Calmed Calmer::calm(const CutRun& run) const {
  const std::vector<CalmStation> s = stations(run);
  const std::vector<std::size_t> at = nodes(s);
  Calmed out;
  std::vector<TurnNode> nodes;
  for (const std::size_t k : at)
    nodes.push_back(
        {s[k].axis, s[k].seconds, off_pole(s[k].axis) > kPoleCones * cone_ ? (1.0 - kStrays) * cone_ : 0.0});
  nodes.front().cone = nodes.back().cone = 0.0;
  std::vector<int> halved(nodes.size(), 0);
  std::vector<AxisAngles> axes = even_turn(nodes, {});
  std::vector<Vec3> v(s.size());
  std::vector<std::uint8_t> held(s.size(), 0);
  for (int round = 1;; ++round) {
    const auto put = [&](std::size_t k, Vec3 to) {
      if (!(v[k] == to)) held[k] = 0;
      v[k] = to;
    };
    put(0, s[0].move.pose.axis);
    for (std::size_t j = 0; j + 1 < at.size(); ++j) {
      const double whole = s[at[j + 1]].seconds - s[at[j]].seconds;
      const bool leans = angle_between(axes[j], nodes[j].axis) > kNoCalmLean ||
                         angle_between(axes[j + 1], nodes[j + 1].axis) > kNoCalmLean;
      for (std::size_t k = at[j] + 1; k <= at[j + 1]; ++k) {
        const bool keeps = k == at[j + 1] && nodes[j + 1].cone <= 0.0;
        const double f = (s[k].seconds - s[at[j]].seconds) / whole;
        put(k, leans && !keeps ? axis(on_way(axes[j], axes[j + 1], f)) : s[k].move.pose.axis);
      }
    }
    std::vector<std::uint8_t> bad(s.size(), 0);
    tbb::parallel_for(std::size_t{1}, s.size(), [&](std::size_t k) {
      const bool leans = !(v[k] == s[k].move.pose.axis) || !(v[k - 1] == s[k - 1].move.pose.axis);
      if (!progress_.go_on(round == 1 && s[k].is_original)) return;
      if (!leans || (held[k] && held[k - 1])) return;
      // Between its nodes the even way may stray further than both.
      const bool may =
          angle_between(v[k], s[k].move.pose.axis) <= cone_ &&
          angle_between(v[k - 1], v[k]) <= longest_turn_ &&
          clear_(stand(centre(s[k - 1].move.pose), v[k - 1]), stand(centre(s[k].move.pose), v[k]));
      bad[k] = may ? 0 : 1;
    });
    if (progress_.cancelled()) return {};
    bool any = false;
    std::vector<std::uint8_t> wanted(nodes.size(), 0);
    for (std::size_t j = 0; j + 1 < at.size(); ++j)
      for (std::size_t k = at[j] + 1; k <= at[j + 1]; ++k)
        if (bad[k]) {
          any = true, ++out.refused;
          wanted[j] = wanted[j + 1] = 1;
        }
    for (std::size_t k = 1; k < s.size(); ++k) held[k] = bad[k] ? 0 : 1;
    if (!any) break;
    const bool late = round >= kMostCalmRounds;
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      if (!wanted[j]) continue;
      nodes[j].cone = late || ++halved[j] > kCalmHalvings ? 0.0 : nodes[j].cone / 2.0;
      if (late) axes[j] = nodes[j].axis;
    }
    if (!late) axes = even_turn(nodes, axes);
  }
  for (std::size_t k = 1; k < s.size(); ++k) {
    Move move = s[k].move;
    const double lean = angle_between(v[k], move.pose.axis);
    const bool stays = v[k] == move.pose.axis && v[k - 1] == s[k - 1].move.pose.axis &&
                       (k + 1 == s.size() || v[k + 1] == s[k + 1].move.pose.axis);
    if (stays && !s[k].is_original) continue;
    if (!(v[k] == move.pose.axis)) {
      move.pose = stand(centre(move.pose), v[k]);
      ++out.points;
      out.largest = std::max(out.largest, lean);
    }
    out.moves.push_back(move);
    out.original.push_back(s[k].is_original ? 1 : 0);
  }
  return out;
}

}  // namespace

Result<CalmPath> calm_axes(const ToolPath& path, Vec3 up, const CalmOptions& options, const MoveCheck& clear,
                           const StageProgress& progress) {
  const std::vector<CutRun> runs = runs_of(path);
  CalmProgress told(progress, runs);
  const Calmer calmer(path, up, options, clear, told);
  std::vector<Calmed> calmed(runs.size());
  told.tell();
  tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t k) {
    if (!told.cancelled()) calmed[k] = calmer.calm(runs[k]);
  });
  if (!told.cancelled()) told.tell();
  if (told.cancelled()) return fail(Code::kCancelled, "cancelled; nothing was written");
  CalmPath out;
  PathSplice splice(path);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    splice.replace(runs[k].first, calmed[k].moves, calmed[k].original);
    out.report.points += calmed[k].points;
    out.report.refused += calmed[k].refused;
    out.report.largest = std::max(out.report.largest, Angle::from_radians(calmed[k].largest));
  }
  out.path = splice.finish();
  return out;
}

}  // namespace tiltfeed
