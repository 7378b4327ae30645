#pragma once
// Whether a list of corners is a polygon that has an inside.

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace tiltfeed::config {

/// A polygon flatter than this share of its length has no area: typed digits are noise by then.
inline constexpr double kFlatPolygon = 1e-9;

struct PolygonFault {
  std::size_t corner = 0;  ///< index of the first corner concerned
  std::string message;
};

/// Why the closed polygon has no clear inside: a corner twice in a row, no area, an edge that turns back on
/// the one before, edges that cross or touch. Corners are counted from 1 in messages. Requires: at least
/// three corners, all finite. Time grows with the square of the number of corners.
std::optional<PolygonFault> polygon_fault(const std::vector<std::array<double, 2>>& corners);

}  // namespace tiltfeed::config
