#include "pathgen/pattern/row_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace tiltfeed::pathgen {

namespace {

/// Directions closer to x' or y' than this (rad) are taken as along it.
constexpr double kStraight = 1e-12;

}  // namespace

FlatLine RowLayout::row(double k) const {
  const double across = first + k * step, x = -dy * across, y = dx * across;
  double from = -std::numeric_limits<double>::infinity(), to = -from;
  const auto cut = [&](double at, double d, double low, double high) {
    if (d == 0.0) return;
    from = std::max(from, std::min((low - at) / d, (high - at) / d));
    to = std::min(to, std::max((low - at) / d, (high - at) / d));
  };
  cut(x, dx, bounds.min_x, bounds.max_x);
  cut(y, dy, bounds.min_y, bounds.max_y);
  return {dx == 0.0 ? x : x + dx * from, dy == 0.0 ? y : y + dy * from, dx, dy, std::max(0.0, to - from)};
}

Result<RowLayout> lay_rows(const FlatIndex& index, const FlatBounds& bounds, const Pattern& pattern,
                           double side_step) {
  if (bounds.max_x < bounds.min_x || bounds.max_y < bounds.min_y)
    return fail(Code::kUnreachable, "containment leaves nothing of the CL surface: widen its limits");
  const double turn = pattern.angle.radians() + (pattern.along == Along::kX ? 0.0 : kPi / 2.0);
  RowLayout raster{bounds, std::cos(turn), std::sin(turn)};
  if (std::abs(raster.dx) < kStraight) raster.dx = 0.0, raster.dy = std::copysign(1.0, raster.dy);
  if (std::abs(raster.dy) < kStraight) raster.dy = 0.0, raster.dx = std::copysign(1.0, raster.dx);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (double x : {bounds.min_x, bounds.max_x})
    for (double y : {bounds.min_y, bounds.max_y}) {
      const double across = y * raster.dx - x * raster.dy;
      low = std::min(low, across), high = std::max(high, across);
    }
  raster.count = std::max(1.0, std::ceil((high - low) / side_step - 1e-9));
  if (raster.count > kMaxRows)
    return fail(Code::kLimit, "pattern.side_step_mm of " + std::to_string(side_step) +
                                  " asks for more than " + std::to_string(static_cast<long long>(kMaxRows)) +
                                  " passes over " + std::to_string(high - low) + " mm; use a larger step");
  raster.step = (high - low) / raster.count;
  raster.first = low + raster.step / 2.0;
  raster.crossings = index.crossings(raster.dx, raster.dy, std::max(raster.step, side_step));
  if (raster.crossings > kMaxCrossings)
    return fail(
        Code::kLimit,
        "pattern.side_step_mm of " + std::to_string(side_step) + " cuts the part's facets " +
            std::to_string(static_cast<long long>(raster.crossings / 1e6)) +
            " million times, more than memory is set aside for; use a larger step, or a coarser mesh");
  return raster;
}

}  // namespace tiltfeed::pathgen
