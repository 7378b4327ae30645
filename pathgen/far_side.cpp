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

bool FarSide::reaches(Point<Flat> centre) const { return map_.column_length(centre) < reach_; }

/// Is the shank's far end in the part, anywhere while the ball's centre goes `lift` up its axis line?
bool FarSide::blocked(Point<Flat> centre, double lift) {
  const double own = std::max(0.0, map_.column_length(centre));
  const double beyond = reach_ + lift - own;
  if (beyond <= 0.0) return false;
  if (!clearance_) clearance_ = std::make_unique<Clearance>(mesh_, radius_);
  const AxisLine line = map_.axis_line(centre.x, centre.y);
  return clearance_->blocked(line.base + line.axis * (centre.z + own), line.axis, beyond);
}

std::uint64_t FarSide::trim(std::vector<std::vector<Pass>>& slices) {
  return leave_out(slices, [this](const EnvelopePoint& p) {
    return blocked(p.flat, std::max(0.0, clearance_z_ - p.flat.z));
  });
}

bool FarSide::travel_clear(const Pose& from, const Pose& to) {
  const auto centre_of = [&](const Pose& pose) { return map_.flatten(pose.tip + pose.axis * ball_radius_); };
  if (!reaches(centre_of(from)) && !reaches(centre_of(to))) return true;
  // No point of the shank moves more than half a radius between two checks.
  const double way = std::max(distance(from.tip, to.tip),
                              distance(from.tip + from.axis * reach_, to.tip + to.axis * reach_));
  const double steps = std::max(1.0, std::ceil(2.0 * way / radius_));
  for (double k = 1.0; k <= steps; ++k) {
    const Pose pose{lerp(from.tip, to.tip, k / steps), slerp(from.axis, to.axis, k / steps)};
    if (blocked(centre_of(pose), 0.0)) return false;
  }
  return true;
}

}  // namespace tiltfeed
