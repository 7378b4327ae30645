#include "pathgen/pattern/region.h"

#include <algorithm>
#include <cmath>

#include "pathgen/envelope/pass_trim.h"

namespace tiltfeed::pathgen {

Region::Region(const Containment& containment, const Deformation& deformation)
    : first_(containment.first), second_(containment.second), height_(containment.height) {
  const AxisMode mode = deformation.frame().mode;
  const bool first_is_angle = mode == AxisMode::kPoint || mode == AxisMode::kCircle;
  const bool second_is_angle = mode != AxisMode::kFixed;
  const double scale_x = first_is_angle ? deformation.scale_x() : 1.0;
  const double scale_y = second_is_angle ? deformation.scale_y() : 1.0;
  first_ = {first_.low * scale_x, first_.high * scale_x};
  second_ = {second_.low * scale_y, second_.high * scale_y};
  if (mode != AxisMode::kFixed) sign_ = deformation.s();
  for (const auto& corner : containment.boundary)
    boundary_.push_back({corner[0] * scale_x, corner[1] * scale_y});
}

FlatBounds Region::within(const FlatBounds& bounds) const {
  FlatBounds b{std::max(bounds.min_x, first_.low), std::min(bounds.max_x, first_.high),
               std::max(bounds.min_y, second_.low), std::min(bounds.max_y, second_.high)};
  for (std::size_t axis = 0; axis < 2 && !boundary_.empty(); ++axis) {
    const auto less = [axis](const auto& a, const auto& c) { return a[axis] < c[axis]; };
    const auto [low, high] = std::minmax_element(boundary_.begin(), boundary_.end(), less);
    double& min = axis == 0 ? b.min_x : b.min_y;
    double& max = axis == 0 ? b.max_x : b.max_y;
    min = std::max(min, (*low)[axis]), max = std::min(max, (*high)[axis]);
  }
  return b;
}

std::vector<FlatLine> Region::inside(const FlatLine& line) const {
  if (boundary_.empty()) return {line};
  // Even-odd: where the line crosses the boundary's edges.
  std::vector<double> runs;
  for (std::size_t i = 0; i < boundary_.size(); ++i) {
    const auto& p = boundary_[i];
    const auto& q = boundary_[(i + 1) % boundary_.size()];
    const auto across = [&](const auto& c) { return (c[1] - line.y) * line.dx - (c[0] - line.x) * line.dy; };
    const auto along = [&](const auto& c) { return (c[0] - line.x) * line.dx + (c[1] - line.y) * line.dy; };
    const double a = across(p), b = across(q);
    if ((a < 0.0) == (b < 0.0)) continue;
    runs.push_back(along(p) + (along(q) - along(p)) * (a / (a - b)));
  }
  std::sort(runs.begin(), runs.end());
  std::vector<FlatLine> pieces;
  for (std::size_t i = 0; i + 1 < runs.size(); i += 2) {
    const double from = std::max(runs[i], 0.0), to = std::min(runs[i + 1], line.length);
    if (from >= to) continue;
    pieces.push_back({line.dx == 0.0 ? line.x : line.x_at(from), line.dy == 0.0 ? line.y : line.y_at(from),
                      line.dx, line.dy, to - from});
  }
  return pieces;
}

bool Region::contains(Point<Flat> f) const { return reaches(f.z) && over(f); }

Interval Region::levels() const {
  if (sign_ > 0.0) return height_;
  return {-height_.high, -height_.low};
}

bool Region::over(Point<Flat> f) const {
  if (!first_.contains(f.x) || !second_.contains(f.y)) return false;
  return in_polygon(boundary_, f.x, f.y);
}

}  // namespace tiltfeed::pathgen
