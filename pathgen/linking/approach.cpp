#include "pathgen/linking/approach.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

Approaches::Approaches(const ClField& field, double approach, double from)
    : field_(field), approach_(approach), from_(from), grown_(field.surface.pieces()) {
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
  // Inside work is nearer to the axis feature the higher it is.
  const double nearest = map.s() > 0 ? place.z : std::max(place.z, from_);
  const Deformation::Distances d = map.distances(line.base + line.axis * nearest);
  const bool y_is_angle = map.frame().mode != AxisMode::kFixed;
  const double half_x = map.period_x() > 0.0 ? within(d.r, map.scale_x()) : approach_;
  const double half_y = y_is_angle ? within(d.rho, map.scale_y()) : approach_;
  const FlatBox round{place.x - half_x, place.x + half_x, place.y - half_y, place.y + half_y};
  double end = place.z + approach_;
  const auto hold_off = [&](PatchId patch) {
    const PatchId features = field_.surface.features(), feature = patch % features;
    for (PatchId i = 0; i < grown_.size(); ++i)
      if (ClHit hit; !field_.surface.is_idle(i * features + feature) &&
                     field_.surface.top(grown_[i], feature, line, hit) && map.in_column(hit.z, angles, 0.0))
        end = std::max(end, hit.z);
  };
  field_.index.near(round, scratch_, nearby_);
  for (const FlatIndex::Nearby& n : nearby_) hold_off(n.patch);
  // Flat height is a distance, so that the grown tool's rises above the tool's own by the approach at most.
  const auto may_reach = [&](const FlatBox&, double top) { return top + approach_ >= end; };
  field_.index.guards().each(round, may_reach, [&](const HullBvh::Found& f) { hold_off(f.patch); });
  return end;
}

}  // namespace tiltfeed::pathgen
