#include "pathgen/raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace tiltfeed {

namespace {

/// Directions closer to x' or y' than this (rad) are taken as along it.
constexpr double kStraight = 1e-12;

/// The piece of the line through (x, y) in direction (dx, dy) that lies in the rectangle.
FlatLine clipped(double x, double y, double dx, double dy, const FlatBounds& b) {
  double from = -std::numeric_limits<double>::infinity(), to = -from;
  const auto cut = [&](double at, double d, double low, double high) {
    if (d == 0.0) return;
    from = std::max(from, std::min((low - at) / d, (high - at) / d));
    to = std::min(to, std::max((low - at) / d, (high - at) / d));
  };
  cut(x, dx, b.min_x, b.max_x);
  cut(y, dy, b.min_y, b.max_y);
  FlatLine line{dx == 0.0 ? x : x + dx * from, dy == 0.0 ? y : y + dy * from, dx, dy,
                std::max(0.0, to - from)};
  return line;
}

}  // namespace

Result<std::vector<FlatLine>> raster_lines(const FlatIndex& index, const Pattern& pattern) {
  const FlatBounds& b = index.bounds();
  const double turn = pattern.angle.radians() + (pattern.along == Along::kX ? 0.0 : kPi / 2.0);
  double dx = std::cos(turn), dy = std::sin(turn);
  if (std::abs(dx) < kStraight) dx = 0.0, dy = std::copysign(1.0, dy);
  if (std::abs(dy) < kStraight) dy = 0.0, dx = std::copysign(1.0, dx);
  // Distance across the lines, to their left, of the rectangle's corners.
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (double x : {b.min_x, b.max_x})
    for (double y : {b.min_y, b.max_y}) {
      low = std::min(low, y * dx - x * dy), high = std::max(high, y * dx - x * dy);
    }
  const double count = std::max(1.0, std::ceil((high - low) / pattern.side_step - 1e-9));
  if (count > kMaxLines)
    return fail(Code::kLimit, "pattern.side_step_mm of " + std::to_string(pattern.side_step) +
                                  " asks for more than " + std::to_string(static_cast<long long>(kMaxLines)) +
                                  " passes over " + std::to_string(high - low) + " mm; use a larger step");
  const double step = (high - low) / count;
  if (const double crossings = index.crossings(dx, dy, std::max(step, pattern.side_step));
      crossings > kMaxCrossings)
    return fail(
        Code::kLimit,
        "pattern.side_step_mm of " + std::to_string(pattern.side_step) + " cuts the part's facets " +
            std::to_string(static_cast<long long>(crossings / 1e6)) +
            " million times, more than memory is set aside for; use a larger step, or a coarser mesh");
  std::vector<FlatLine> lines;
  lines.reserve(static_cast<std::size_t>(count));
  for (double k = 0.0; k < count; ++k) {
    const double across = step > 0.0 ? low + (k + 0.5) * step : low;
    lines.push_back(clipped(-dy * across, dx * across, dx, dy, b));
  }
  return lines;
}

}  // namespace tiltfeed
