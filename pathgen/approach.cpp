#include "pathgen/approach.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {

Approaches::Approaches(const ClField& field, double approach)
    : field_(field), approach_(approach), grown_(field.surface.pieces()) {
  for (ToolPiece& piece : grown_) piece.corner += approach, piece.outer += approach * piece.taper_cos;
}

double Approaches::rapid_end(Point<Flat> place) {
  const Deformation& map = field_.deformation;
  Deformation::Angles angles;
  const AxisLine line = map.axis_line(place.x, place.y, angles);
  // A place of the grown tool's CL surface lies the approach away from that of the tool's own with the same
  // contact; in flat space by what that is seen under from the axis feature.
  const auto within = [&](double distance, double scale) {
    if (std::isinf(distance)) return approach_;
    return distance > 2.0 * approach_ ? scale * std::asin(approach_ / (distance - approach_)) : scale * kPi;
  };
  const Deformation::Distances d = map.distances(line.base + line.axis * place.z);
  const bool y_is_angle = map.frame().mode != AxisMode::kFixed;
  const double half_x = map.period_x() > 0.0 ? within(d.r, map.scale_x()) : approach_;
  const double half_y = y_is_angle ? within(d.rho, map.scale_y()) : approach_;
  field_.index.near({place.x - half_x, place.x + half_x, place.y - half_y, place.y + half_y}, scratch_,
                    nearby_);
  double end = place.z + approach_;
  for (const FlatIndex::Nearby& n : nearby_) {
    const PatchId feature = n.patch % field_.surface.features();
    for (const ToolPiece& piece : grown_)
      if (ClHit hit; field_.surface.top(piece, feature, line, hit) && map.in_column(hit.z, angles, 0.0))
        end = std::max(end, hit.z);
  }
  return end;
}

}  // namespace tiltfeed
