#include "sim/path_check/path_matching.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace tiltfeed::sim {
namespace {

// Lever that weighs an axis error against a tip error: 0.1 degrees count as 0.017 mm.
constexpr double kArm = 10.0;
// Price of being further along than the tool has moved, per mm: high enough that a hundredth of a mm of
// deviation cannot pay for skipping more than two of them, low enough to catch up after a gap.
constexpr double kHurry = 0.5;
// Moves looked through ahead of the last place before the walk stays where it is.
constexpr std::uint32_t kLookAhead = 20000;

struct Pair {
  Vec3 tip, arm;
};
Pair difference(const Pose& a, const Pose& b) { return {a.tip - b.tip, (a.axis - b.axis) * kArm}; }
double inner(const Pair& a, const Pair& b) { return dot(a.tip, b.tip) + dot(a.arm, b.arm); }

/// The fraction of the way from a to b that is nearest to p, at least `least`.
double nearest_fraction(const Pose& a, const Pose& b, const Pose& p, double least) {
  const Pair along = difference(b, a);
  const double whole = inner(along, along);
  return whole > 0.0 ? std::clamp(inner(difference(p, a), along) / whole, least, 1.0) : 1.0;
}

double pair_distance(const Pose& a, const Pose& b, double f, const Pose& p) {
  const Pair along = difference(b, a), m = difference(p, a);
  const Pair off{m.tip - along.tip * f, m.arm - along.arm * f};
  return std::sqrt(inner(off, off));
}

double tip_distance(Point<Part> a, Point<Part> b, Point<Part> p) {
  const Vec3 along = b - a, m = p - a;
  const double whole = squared_length(along);
  return length(m - along * (whole > 0.0 ? std::clamp(dot(m, along) / whole, 0.0, 1.0) : 0.0));
}

}  // namespace

PathMatching::PathMatching(const ToolPath& planned)
    : planned_(planned), visited_(planned.moves.size(), std::numeric_limits<double>::infinity()) {
  assert(!planned.moves.empty());
}

PathMatching::Match PathMatching::seek(const Pose& executed, double moved) const {
  const auto& moves = planned_.moves;
  Match best{move_, fraction_, std::numeric_limits<double>::infinity()};
  const auto last =
      static_cast<std::uint32_t>(std::min<std::size_t>(moves.size() - 1, std::size_t{move_} + kLookAhead));
  double ahead = 0.0;  // along the path from the last place to the start of move j
  for (std::uint32_t j = std::max(move_, 1u); j <= last; ++j) {
    const double price = kHurry * std::max(0.0, ahead - moved);
    if (price >= best.cost) break;
    const Pose &from = moves[j - 1].pose, &to = moves[j].pose;
    const double least = j == move_ ? fraction_ : 0.0;
    const Pair along = difference(to, from);
    const double size = std::sqrt(inner(along, along));
    const double f = nearest_fraction(from, to, executed, least);
    const double further = ahead + size * (f - least);
    const double cost = pair_distance(from, to, f, executed) + kHurry * std::max(0.0, further - moved);
    if (cost < best.cost) best = {j, f, cost};
    ahead += size * (1.0 - least);
  }
  return best;
}

PathPlace PathMatching::step(const Pose& executed) {
  const auto& moves = planned_.moves;
  if (!started_) before_ = executed, started_ = true;
  const Pair step = difference(executed, before_);
  const Match match = seek(executed, std::sqrt(inner(step, step)));
  for (std::uint32_t v = move_ > 0 ? move_ - 1 : 0; v <= match.move; ++v)
    visited_[v] = std::min(visited_[v], tip_distance(before_.tip, executed.tip, moves[v].pose.tip));
  move_ = match.move, fraction_ = match.fraction, before_ = executed;

  if (move_ == 0) {  // a path of one pose
    const Pose& only = moves[0].pose;
    return {0, distance(only.tip, executed.tip), angle_between(only.axis, executed.axis)};
  }
  PathPlace place{move_, std::numeric_limits<double>::infinity(), 0.0};
  const auto end =
      static_cast<std::uint32_t>(std::min<std::size_t>(moves.size() - 1, std::size_t{move_} + 1));
  for (std::uint32_t j = std::max(move_ - 1, 1u); j <= end; ++j)
    place.distance =
        std::min(place.distance, tip_distance(moves[j - 1].pose.tip, moves[j].pose.tip, executed.tip));
  const Vec3 planned_axis = slerp(moves[move_ - 1].pose.axis, moves[move_].pose.axis, fraction_);
  place.angle = angle_between(planned_axis, executed.axis);
  return place;
}

}  // namespace tiltfeed::sim
