#include "pathgen/linking/travel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

/// Share of the clearance that a straight travel move may dip below the clearance surface.
constexpr double kDipShare = 0.1;
/// More tilt than this over the limit (rad) counts: the rounding of a cosine near 0 and 180 degrees is less,
/// and so is what a machine can tell.
constexpr double kTiltSlack = 1e-6;
/// How far detours lean from the straight way to that of least tilt. The small ones make up for what the
/// great circle of one move bulges over a limit that both its ends just keep.
constexpr double kLeans[] = {1.0 / 64.0, 1.0 / 16.0, 1.0 / 4.0, 1.0};
/// Turn of Theta between two corners of a detour (rad): its way of least tilt is not straight in flat space.
constexpr double kDetourTurn = 0.1;
/// Poses nearer than this (mm) need no move between them.
constexpr double kSamePlace = 1e-9;

}  // namespace

Travel::Travel(const Deformation& deformation, const Linking& options, OppositeWall& opposite_wall,
               IsOver is_over)
    : map_(deformation),
      options_(options),
      opposite_wall_(opposite_wall),
      is_over_(std::move(is_over)),
      unlimited_(options.tilt_max.radians() + kTiltSlack >= kPi),
      least_allowed_(std::cos(std::min(kPi, options.tilt_max.radians() + kTiltSlack))) {}

Pose Travel::pose(Point<Flat> f) const {
  const AxisLine line = map_.axis_line(f.x, f.y);
  return pose_at(line.base + line.axis * f.z, line.axis, options_.reference_height);
}

Travel::Way Travel::find(Point<Flat> from, Point<Flat> to, std::vector<Pose>& poses) {
  from.z = to.z = options_.clearance_z;
  const Point<Flat> target = map_.beside(to, from);
  const Pose start = pose(from);
  poses = poses_of({from, target}, false);
  Way way = check(start, poses, {from, target});
  if (way == Way::kFound || map_.frame().mode == AxisMode::kFixed) return way;
  struct Ranked {
    Corners corners;
    std::vector<Pose> poses;
    double length = 0.0;
  };
  std::vector<Ranked> candidates;
  for (Corners& corners : detours(from, target)) {
    std::vector<Pose> over = poses_of(corners, true);
    candidates.push_back({std::move(corners), std::move(over), 0.0});
    if (candidates.back().poses.empty()) {
      candidates.pop_back();
      continue;
    }
    const Pose* at = &start;
    for (const Pose& next : candidates.back().poses) {
      candidates.back().length += distance(at->tip, next.tip);
      at = &next;
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Ranked& a, const Ranked& b) { return a.length < b.length; });
  for (Ranked& candidate : candidates) {
    const Way answer = check(start, candidate.poses, candidate.corners);
    if (answer == Way::kFound) {
      poses = std::move(candidate.poses);
      return answer;
    }
    if (answer == Way::kBlocked) way = answer;
  }
  poses.clear();
  return way;
}

/// (L2) Steps whose chords dip at most kDipShare of the clearance: rho * turn^2 / 8.
double Travel::steps(Point<Flat> from, Point<Flat> to) const {
  if (map_.frame().mode == AxisMode::kFixed) return 1.0;
  const double turn_x = map_.period_x() > 0.0 ? std::abs(to.x - from.x) / map_.scale_x() : 0.0;
  const double turn_y = std::abs(to.y - from.y) / map_.scale_y();
  const double rho = std::abs(options_.clearance_z) + map_.frame().circle_radius_or_zero();
  return std::max(1.0, std::ceil((turn_x + turn_y) / std::sqrt(8.0 * kDipShare * options_.clearance / rho)));
}

/// Along straight lines of flat space from corner to corner, the first left out. Detours stay in their own
/// columns, where nothing is above the clearance surface; one that does not has no poses.
std::vector<Pose> Travel::poses_of(const Corners& corners, bool detour) const {
  std::vector<Pose> poses;
  for (std::size_t c = 1; c < corners.size(); ++c) {
    const double count = steps(corners[c - 1], corners[c]);
    for (double i = 1.0; i <= count; ++i) {
      const Point<Flat> place = lerp(corners[c - 1], corners[c], i / count);
      if (detour && !map_.in_column(place, kLeastAxisDistance)) return {};
      const Pose next = pose(place);
      const bool moved = poses.empty() || distance(poses.back().tip, next.tip) > kSamePlace ||
                         length(poses.back().axis - next.axis) > kSamePlace;
      if (moved) poses.push_back(next);
    }
  }
  return poses;
}

Travel::Way Travel::check(const Pose& start, const std::vector<Pose>& poses, const Corners& corners) {
  const Pose* at = &start;
  for (const Pose& next : poses) {
    if (!within_tilt(at->axis, next.axis)) return Way::kTilted;
    at = &next;
  }
  at = &start;
  for (const Pose& next : poses) {
    if (!opposite_wall_.travel_clear(*at, next) || (options_.in_blank && options_.in_blank(*at, next)))
      return Way::kBlocked;
    at = &next;
  }
  // (L2) Each move may dip that much.
  const double dip = kDipShare * options_.clearance;
  for (std::size_t i = 1; is_over_ && i < corners.size(); ++i) {
    Point<Flat> from = corners[i - 1], to = corners[i];
    from.z -= dip, to.z -= dip;
    if (!is_over_(from, to)) return Way::kBlocked;
  }
  return Way::kFound;
}

/// (L4) The y' of least tilt in a column x', the image nearest to near_y; point and circle.
double Travel::least_tilt_y(double x, double near_y) const {
  const AxisFrame& frame = map_.frame();
  const double theta = x / map_.scale_x();
  const Vec3 out = frame.n * std::cos(theta) + frame.t * std::sin(theta);
  double phi = std::atan2(map_.s() * dot(map_.b(), options_.up), map_.s() * dot(out, options_.up));
  if (frame.mode == AxisMode::kPoint) phi = std::clamp(phi, -kPi / 2.0, kPi / 2.0);
  return short_way(near_y, phi * map_.scale_y(), map_.period_y());
}

/// From `from` towards the way of least tilt, along it, and to `to`; `share` of the way there.
Travel::Corners Travel::detour(Point<Flat> from, Point<Flat> to, double share) const {
  const double count = std::max(1.0, std::ceil(std::abs(to.x - from.x) / (kDetourTurn * map_.scale_x())));
  Corners corners{from};
  double near_y = from.y;
  for (double k = 0.0; k <= count; ++k) {
    const Point<Flat> straight = lerp(from, to, k / count);
    near_y = least_tilt_y(straight.x, near_y);
    corners.push_back({straight.x, straight.y + share * (near_y - straight.y), straight.z});
  }
  corners.push_back({to.x, short_way(corners.back().y, to.y, map_.period_y()), to.z});
  return corners;
}

std::vector<Travel::Corners> Travel::detours(Point<Flat> from, Point<Flat> to) const {
  const auto images = [](double at, double target, double period) {
    std::vector<double> both{target};
    if (period > 0.0) both.push_back(target > at ? target - period : target + period);
    return both;
  };
  std::vector<Corners> found;
  for (const double x : images(from.x, to.x, map_.period_x())) {
    for (const double y : images(from.y, to.y, map_.period_y()))
      if (x != to.x || y != to.y) found.push_back({from, {x, y, to.z}});
    // Without a limit there is no use in leaning; along a line y' alone tilts.
    if (unlimited_ || map_.frame().mode == AxisMode::kLine) continue;
    for (const double lean : kLeans) found.push_back(detour(from, {x, to.y, to.z}, lean));
  }
  return found;
}

}  // namespace tiltfeed::pathgen
