#include "pathgen/move_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tiltfeed {

namespace {

/// Up to so many radii of the ball over the reference moves are checked pose by pose, further up by a bound.
constexpr double kBoundedFrom = 3.0;
/// A cylinder of radius r that steps by s leaves s^2 / (8 r) of a corner: a fifth of the tolerance at most.
constexpr double kStepShare = 8.0 * 0.2;

/// Of the room that a move has over a plane surface, how much it may take: facets are not in one plane.
constexpr double kBoundShare = 0.7;
/// In more pieces than this a bound takes longer than poses.
constexpr double kMostPieces = 16.0;
/// All of the tool.
constexpr double kFromBelow = -std::numeric_limits<double>::infinity();

double lever(const SweptTool& tool) {
  const Box& b = tool.tree().bounds();
  return std::min(tool.top(), distance(b.min, b.max));
}

}  // namespace

PlacedRun divided(const PlacedRun& run, const OrientationOptions& options) {
  PlacedRun parts{run.front()};
  for (std::size_t i = 1; i < run.size(); ++i) {
    const PlacedPoint &a = run[i - 1], &b = run[i];
    const double turn = angle_between(a.at.axis, b.at.axis),
                 way = distance(a.at.point.centre, b.at.point.centre);
    int count = static_cast<int>(std::ceil(turn / options.turn_per_move - 1e-9));
    if (options.longest_move > 0.0)
      count = std::max(count, static_cast<int>(std::ceil(way / options.longest_move - 1e-9)));
    for (int k = 1; k < count; ++k) {
      const double f = static_cast<double>(k) / count;
      ClPoint p = f < 0.5 ? a.at.point : b.at.point;
      p.centre = lerp(a.at.point.centre, b.at.point.centre, f);
      parts.push_back({a.way + (b.way - a.way) * f, {p, slerp(a.at.axis, b.at.axis, f)}});
    }
    parts.push_back(b);
  }
  return parts;
}

MoveCheck::MoveCheck(const Admissibility& admissible, const OrientationOptions& options,
                     DirectionQuery& query)
    : admissible_(admissible),
      options_(options),
      query_(query),
      lever_(lever(admissible.tool())),
      step_(std::sqrt(kStepShare * admissible.tool().ball() * options.tolerance)) {}

void MoveCheck::next_round() {
  std::stable_sort(now_.begin(), now_.end(),
                   [](const Cleared& a, const Cleared& b) { return a.from < b.from; });
  before_ = std::exchange(now_, {});
}

bool MoveCheck::known_clear(const PlacedPoint& a, const PlacedPoint& b) const {
  const auto earlier = [](const Cleared& c, double way) { return c.from < way; };
  for (auto c = std::lower_bound(before_.begin(), before_.end(), a.way, earlier);
       c != before_.end() && c->from == a.way; ++c)
    if (c->to == b.way && c->axes[0] == a.at.axis && c->axes[1] == b.at.axis) return true;
  return false;
}

bool MoveCheck::clear(const PlacedPoint& a, const PlacedPoint& b) {
  if (!known_clear(a, b) && !clear(a.at, b.at)) return false;
  now_.push_back({a.way, {a.at.axis, b.at.axis}, b.way});
  return true;
}

/// (O5) By how much all of the tool may move without a doubt where its axis leans from the surface's normal
/// by q, `lean` its cosine: a cylinder of radius R that moves and grows by m stays off a plane under its ball
/// while m (cos q + sin q) < R (1 - sin q).
double MoveCheck::room(double lean) const {
  const double sine = std::sqrt(std::max(0.0, 1.0 - lean * lean));
  return kBoundShare * admissible_.tool().ball() * (1.0 - sine) / (std::max(lean, 0.0) + sine);
}

/// In pieces so short that the bound can hold.
bool MoveCheck::clear_by_bound(const OrientedPoint& a, const OrientedPoint& b) {
  const SweptTool& tool = admissible_.tool();
  const double turn = angle_between(a.axis, b.axis), way = distance(a.point.centre, b.point.centre);
  const double bent = options_.reference_height * turn * turn / 8.0;
  const double spare = room(std::min(dot(a.axis, a.point.normal), dot(b.axis, b.point.normal))) - bent;
  const double moved = way / 2.0 + tool.ball() * turn;
  if (spare <= 0.0 || moved > kMostPieces * spare || !admissible_.within_tilt(a.axis) ||
      !admissible_.within_tilt(b.axis) || !admissible_.within_tilt(slerp(a.axis, b.axis, 0.5)))
    return false;
  const int pieces = std::max(1, static_cast<int>(std::ceil(moved / spare)));
  for (int k = 0; k < pieces; ++k) {
    const double f = (k + 0.5) / pieces;
    ++query_.tested;
    if (tool.may_stop(lerp(a.point.centre, b.point.centre, f), slerp(a.axis, b.axis, f),
                      way / (2.0 * pieces) + bent, turn / (2.0 * pieces), kFromBelow))
      return false;
  }
  return true;
}

/// High up by a bound; near the contact, or where that does not tell, at poses between which no point of the
/// tool moves further than what a ball leaves of a corner between two places within its share of the
/// tolerance.
bool MoveCheck::clear(const OrientedPoint& a, const OrientedPoint& b) {
  const SweptTool& tool = admissible_.tool();
  const double turn = angle_between(a.axis, b.axis), way = distance(a.point.centre, b.point.centre);
  const double from = kBoundedFrom * tool.ball();
  if (clear_by_bound(a, b)) return true;
  ++query_.tested;
  const bool bounded = !tool.may_stop(lerp(a.point.centre, b.point.centre, 0.5), slerp(a.axis, b.axis, 0.5),
                                      way / 2.0, turn / 2.0, from);
  const int steps =
      std::max(1, static_cast<int>(std::ceil((way + (bounded ? from : lever_) * turn) / step_)));
  const double h = options_.reference_height;
  const Point<Part> tip_a = a.point.centre - a.axis * h, tip_b = b.point.centre - b.axis * h;
  for (int k = 0; k <= steps; ++k) {
    const double f = static_cast<double>(k) / steps;
    const Vec3 axis = slerp(a.axis, b.axis, f);
    const Point<Part> centre = lerp(tip_a, tip_b, f) + axis * h;
    ++query_.tested;
    if (bounded ? tool.stopped_below(centre, axis, from, query_.hint)
                : tool.stop(centre, axis, query_.hint).has_value())
      return false;
    if (!admissible_.within_tilt(axis)) return false;
  }
  return true;
}

}  // namespace tiltfeed
