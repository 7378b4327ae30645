#include "pathgen/free_axis/move_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

/// Of the room that a move has over a plane surface, how much it may take: facets are not in one plane.
constexpr double kBoundShare = 0.7;
/// In more pieces than this a bound takes longer than poses.
constexpr double kMostPieces = 16.0;
/// All of the tool.
constexpr double kFromBelow = -std::numeric_limits<double>::infinity();

}  // namespace

PlacedRun divided(const PlacedRun& run, const ToolAxisOptions& options) {
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

MoveCheck::MoveCheck(const Admissibility& admissible, const ToolAxisOptions& options, DirectionQuery& query)
    : admissible_(admissible), options_(options), query_(query) {}

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
bool MoveCheck::clear_by_bound(const ToolAxisPoint& a, const ToolAxisPoint& b) {
  const SweptTool& tool = admissible_.tool();
  const double turn = angle_between(a.axis, b.axis), way = distance(a.point.centre, b.point.centre);
  const double bent = options_.reference_height * turn * turn / 8.0;
  const double spare = room(std::min(dot(a.axis, a.point.normal), dot(b.axis, b.point.normal))) - bent;
  const double moved = way / 2.0 + tool.ball() * turn;
  if (spare <= 0.0 || moved > kMostPieces * spare || !admissible_.within_tilt(a.axis, b.axis)) return false;
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

/// By one bound where the surface leaves room, else as any move.
bool MoveCheck::clear(const ToolAxisPoint& a, const ToolAxisPoint& b) {
  return clear_by_bound(a, b) || clear_along(admissible_.tool(), admissible_.tilt(), {a.point.centre, a.axis},
                                             {b.point.centre, b.axis}, options_.reference_height,
                                             options_.tolerance, query_.hint, query_.tested);
}

}  // namespace tiltfeed::pathgen
