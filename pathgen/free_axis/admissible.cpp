#include "pathgen/free_axis/admissible.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// An axis steeper than this against the surface normal (cosine of 89 degrees) would cut with its side alone.
constexpr double kAlongSurface = 0.0175;
/// Directions turned to the tilt limit stay this much (rad) within it: beyond 90 degrees the great circle
/// between two of one tilt dips below them, and by less than this where it is up to 25 degrees long.
constexpr double kWithinTilt = 0.01;
constexpr int kAllParts = kWithFixtures;
/// Neighbours of a direction are those that the axis may turn to between two stations, and some: as a chord.
constexpr double kNearChord = 0.6;

}  // namespace

Admissibility::Admissibility(const SweptTool& tool, const DirectionGrid& grid, Vec3 up, Angle tilt_max)
    : tool_(tool),
      grid_(grid),
      near_(grid, kAdmissibleLevel, kNearChord),
      up_(up),
      tilt_max_(tilt_max.radians()),
      tilt_(up, tilt_max) {}

bool Admissibility::within_limits(Vec3 normal, Vec3 axis) const {
  return dot(normal, axis) >= kAlongSurface && within_tilt(axis);
}

bool Admissibility::admits(const ClPoint& point, Vec3 axis, DirectionQuery& query) const {
  if (!within_limits(point.normal, axis)) return false;
  ++query.tested;
  return !tool_.stop(point.centre, axis, query.hint);
}

bool Admissibility::stopped(const ClPoint& point, std::uint32_t i, int parts, DirectionQuery& query) const {
  ++query.tested;
  std::vector<std::uint32_t>& blockers = query.blockers[static_cast<std::size_t>(parts) - 1];
  if (blockers.empty()) blockers.assign(grid_.directions().size(), kNoFacet);
  const Vec3 axis = grid_.directions()[i];
  const auto known = [&](const std::vector<std::uint32_t>& of) {
    return !of.empty() && of[i] != kNoFacet && tool_.stopped_by(of[i], point.centre, axis, parts);
  };
  if (known(blockers) || (parts < kAllParts && known(query.blockers[kAllParts - 1]))) return true;
  if (!tool_.stop(point.centre, axis, query.hint, parts)) return false;
  blockers[i] = query.hint;
  return true;
}

bool Admissibility::admits(const ClPoint& point, std::uint32_t i, DirectionQuery& query) const {
  return within_limits(point.normal, grid_.directions()[i]) && !stopped(point, i, kAllParts, query);
}

bool Admissibility::still_stopped(const ClPoint& point, std::uint32_t i, DirectionQuery& query) const {
  const std::vector<std::uint32_t>& blockers = query.blockers[kAllParts - 1];
  if (blockers.empty() || blockers[i] == kNoFacet) return false;
  ++query.tested;
  return tool_.stopped_by(blockers[i], point.centre, grid_.directions()[i], kAllParts);
}

bool Admissibility::any_clear(const ClPoint& point, int parts, DirectionQuery& query) const {
  // All three parts are asked about only where the tilt limit is what has been in the way.
  const bool beyond_tilt = parts == kAllParts;
  const std::uint32_t count = DirectionGrid::count(kAdmissibleLevel + 1);
  std::uint32_t& last = query.clear[static_cast<std::size_t>(parts) - 1];
  for (std::uint32_t k = 0; k <= count; ++k) {
    const std::uint32_t i = k == 0 ? last : k - 1;
    const Vec3 axis = grid_.directions()[i];
    if (dot(point.normal, axis) < kAlongSurface || (beyond_tilt && within_tilt(axis))) continue;
    if (!stopped(point, i, parts, query)) return last = i, true;
  }
  return false;
}

RestReason Admissibility::why_none(const ClPoint& point, DirectionQuery& query) const {
  if (tilt_max_ < kPi && any_clear(point, kAllParts, query)) return RestReason::kTilt;
  if (!any_clear(point, kCutterOnly, query)) return RestReason::kCutter;
  if (!any_clear(point, kWithShank, query)) return RestReason::kShank;
  if (tool_.at_fixtures() == nullptr) return RestReason::kHolder;
  return any_clear(point, kWithHolder, query) ? RestReason::kFixture : RestReason::kHolder;
}

Vec3 Admissibility::nearest_tilt(Vec3 axis) const {
  if (tilt_max_ >= kPi) return axis;
  const double within = std::max(0.0, tilt_max_ - kWithinTilt);
  if (angle_between(axis, up_) <= within) return axis;
  const Vec3 aside = axis - up_ * dot(axis, up_);
  const Vec3 out = squared_length(aside) > 1e-18
                       ? normalized(aside)
                       : normalized(cross(up_, std::abs(up_.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  return up_ * std::cos(within) + out * std::sin(within);
}

}  // namespace tiltfeed::pathgen
