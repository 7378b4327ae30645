#include "pathgen/far_side.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {

FarSide::FarSide(const Mesh& mesh, const Deformation& deformation, const Cutter& cutter, double allowance,
                 double clearance_z)
    : mesh_(mesh),
      map_(deformation),
      radius_(cutter.radius() + allowance),
      reach_(cutter.shank_length - cutter.radius()),
      clearance_z_(clearance_z),
      ball_radius_(cutter.radius()) {}

/// Does the shank round the segment from the ball's centre, `length` up the axis, cut into the part? The ray
/// starts at the ball, where the way is known to be free, so that it cannot start inside what it looks for.
bool FarSide::blocked(Point<Part> centre, Vec3 axis, double length) {
  if (!clearance_) clearance_ = std::make_unique<Clearance>(mesh_, radius_);
  return clearance_->blocked(centre, axis, length);
}

std::uint64_t FarSide::trim(std::vector<std::vector<Pass>>& slices) {
  return leave_out(slices, [this](const EnvelopePoint& p) {
    // What the shank reaches while the ball goes up to the clearance surface.
    const double length = reach_ + std::max(0.0, clearance_z_ - p.flat.z);
    return map_.column_length(p.flat) < length && blocked(p.centre, p.axis, length);
  });
}

bool FarSide::travel_clear(const Pose& from, const Pose& to) {
  const auto centre_of = [&](const Pose& pose) { return pose.tip + pose.axis * ball_radius_; };
  const auto reaches = [&](const Pose& pose) {
    return map_.column_length(map_.flatten(centre_of(pose))) < reach_;
  };
  if (!reaches(from) && !reaches(to)) return true;
  // No point of the shank moves more than a quarter radius between two checks.
  const double way = std::max(distance(from.tip, to.tip),
                              distance(from.tip + from.axis * reach_, to.tip + to.axis * reach_));
  const double steps = std::max(1.0, std::ceil(4.0 * way / radius_));
  for (double k = 1.0; k <= steps; ++k) {
    const Pose pose{lerp(from.tip, to.tip, k / steps), slerp(from.axis, to.axis, k / steps)};
    if (blocked(centre_of(pose), pose.axis, reach_)) return false;
  }
  return true;
}

}  // namespace tiltfeed
