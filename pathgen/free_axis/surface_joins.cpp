#include "pathgen/free_axis/surface_joins.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// Of the tolerance, by which the ball may stand off the part on a join where it is looked at; slices have
/// twice as much.
constexpr double kGapShare = 0.2;
/// So many parts of a move are looked at; it is no longer than this share of the ball's radius.
constexpr int kLooks = 8;
constexpr double kLongest = 0.5;
/// A way over the surface is no longer than so many times the straight one.
constexpr double kDetour = 1.6;
/// A place is moved on to the CL surface in so many steps, each from the facet that is nearest; to this
/// distance, mm.
constexpr int kMostSteps = 20;
constexpr double kSettled = 1e-7;
/// A move is halved so often at most.
constexpr int kMostHalvings = 8;

}  // namespace

SurfaceJoins::SurfaceJoins(const Admissibility& admissible, const ToolAxisOptions& options, double longest)
    : admissible_(admissible),
      options_(options),
      longest_(longest),
      gap_(kGapShare * options.tolerance),
      moves_(admissible, options, query_) {}

/// Where the ball touches the part when it is moved, near `centre`, towards the nearest facet or away from
/// it.
std::optional<ClPoint> SurfaceJoins::contact(Point<Part> centre) const {
  const SweptTool& tool = admissible_.tool();
  const double reach = tool.ball() + 0.5 * longest_;
  for (int step = 0; step < kMostSteps; ++step) {
    double least = reach;
    Point<Part> foot{};
    std::uint32_t facet = kNoFacet;
    tool.tree().nearest(centre, reach, [&](std::uint32_t f, const PlacedFacet& placed) {
      const Point<Part> near = nearest_point(centre, placed.corners);
      const double away = distance(centre, near);
      if (away < least || (away == least && f < facet)) least = away, foot = near, facet = f;
      return away;
    });
    if (facet == kNoFacet || least < 1e-3 * tool.ball()) return std::nullopt;
    const Vec3 normal = (centre - foot) / least;
    if (std::abs(least - tool.ball()) < kSettled) return ClPoint{centre, normal, facet};
    centre = foot + normal * tool.ball();
  }
  return std::nullopt;
}

/// Does the ball on the straight way stand off its contact by no more than the gap?
bool SurfaceJoins::straight_is_near(const ClPoint& a, const ClPoint& b) const {
  for (int k = 1; k < kLooks; ++k) {
    const Point<Part> straight = lerp(a.centre, b.centre, static_cast<double>(k) / kLooks);
    const auto touching = contact(straight);
    if (!touching || distance(touching->centre, straight) > gap_) return false;
  }
  return true;
}

/// Appends the places after a, up to and with b, between which the ball stays in contact.
bool SurfaceJoins::follow(const ClPoint& a, const ClPoint& b, int depth, ClStrand& way) const {
  if (distance(a.centre, b.centre) <= kLongest * admissible_.tool().ball() && straight_is_near(a, b))
    return way.push_back(b), true;
  if (depth == kMostHalvings) return false;
  const auto middle = contact(lerp(a.centre, b.centre, 0.5));
  return middle && follow(a, *middle, depth + 1, way) && follow(*middle, b, depth + 1, way);
}

std::optional<ToolAxisRun> SurfaceJoins::join(const ToolAxisPoint& from, const ToolAxisPoint& to) {
  const double apart = distance(from.point.centre, to.point.centre);
  if (apart > longest_ || apart < kSettled) return std::nullopt;
  ClStrand way{from.point};
  if (!follow(from.point, to.point, 0, way)) return std::nullopt;
  const double length = length_of(way), turn = angle_between(from.axis, to.axis);
  if (length > kDetour * apart || turn > options_.wish.max_turn.radians() * length) return std::nullopt;
  PlacedRun run{{0.0, from}};
  for (std::size_t i = 1; i < way.size(); ++i) {
    const double at = run.back().way + distance(way[i - 1].centre, way[i].centre);
    const Vec3 axis = i + 1 == way.size() ? to.axis : slerp(from.axis, to.axis, at / length);
    const SweptTool& tool = admissible_.tool();
    if (!admissible_.within_limits(way[i].normal, axis) ||
        !in_contact(way[i - 1].centre, way[i].centre, tool.tree(), tool.ball(), gap_))
      return std::nullopt;
    run.push_back({at, {way[i], axis}});
  }
  run = divided(run, options_);
  ToolAxisRun joined;
  for (std::size_t i = 1; i < run.size(); ++i) {
    if (!moves_.clear(run[i - 1].at, run[i].at)) return std::nullopt;
    joined.push_back(run[i].at);
  }
  return joined;
}

}  // namespace tiltfeed::pathgen
