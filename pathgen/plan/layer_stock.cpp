#include "pathgen/plan/layer_stock.h"

#include <algorithm>

#include "pathgen/pattern/region.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

namespace {

/// By rounding, a place of a floor may be as much under it, mm.
constexpr double kSameFloor = 1e-6;
/// The least distance along a line is found to 1e-9 of its length.
constexpr int kThirds = 52;

double distance_to(const Box& box, Point<Part> p) {
  const Point<Part> nearest{std::clamp(p.x, box.min.x, box.max.x), std::clamp(p.y, box.min.y, box.max.y),
                            std::clamp(p.z, box.min.z, box.max.z)};
  return distance(p, nearest);
}

}  // namespace

LayerStock::LayerStock(const Box& part, const PlanOptions& options, const Deformation& map,
                       const std::vector<double>& floors, double clearance_z)
    : part_(part),
      options_(options),
      map_(map),
      floors_(floors),
      clearance_z_(clearance_z),
      box_known_(!options.blank && !Region(options.containment, map).limited()),
      radius_(tool_pieces(options).front().outer) {}

double LayerStock::free_from(Point<Flat> place, double to) const {
  const auto above = std::find_if(floors_.rbegin(), floors_.rend(),
                                  [&](double floor) { return floor > place.z + kSameFloor; });
  if (above == floors_.rend() || beside_box(place, to)) return to;
  return std::max(to, std::min(*above + options_.links.approach, clearance_z_));
}

/// Does the cutting part stay out of the part's box, but for the tolerance, all the way down?
bool LayerStock::beside_box(Point<Flat> place, double to) const {
  if (!box_known_) return false;
  const AxisLine line = map_.axis_line(place.x, place.y);
  const auto off = [&](double z) { return distance_to(part_, line.base + line.axis * z); };
  // A distance to a convex body falls along a line, and rises again.
  double low = to, high = std::max(to, clearance_z_);
  for (int i = 0; i < kThirds; ++i) {
    const double third = (high - low) / 3.0;
    if (off(low + third) < off(high - third))
      high -= third;
    else
      low += third;
  }
  return off((low + high) / 2.0) >= radius_ - options_.tolerance;
}

}  // namespace tiltfeed::pathgen
