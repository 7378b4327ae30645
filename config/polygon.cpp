#include "config/polygon.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace tiltfeed::config {
namespace {

using Corner = std::array<double, 2>;

/// Twice the signed area of the triangle a, b, c.
double turn(const Corner& a, const Corner& b, const Corner& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double distance(const Corner& a, const Corner& b) { return std::hypot(b[0] - a[0], b[1] - a[1]); }

/// Whether c, known to be in line with a and b, lies between them.
bool between_ends(const Corner& a, const Corner& b, const Corner& c) {
  return std::min(a[0], b[0]) <= c[0] && c[0] <= std::max(a[0], b[0]) && std::min(a[1], b[1]) <= c[1] &&
         c[1] <= std::max(a[1], b[1]);
}

/// Whether the segments ab and cd share a point.
bool meet(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
  const double abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  if (((abc > 0 && abd < 0) || (abc < 0 && abd > 0)) && ((cda > 0 && cdb < 0) || (cda < 0 && cdb > 0)))
    return true;
  return (abc == 0 && between_ends(a, b, c)) || (abd == 0 && between_ends(a, b, d)) ||
         (cda == 0 && between_ends(c, d, a)) || (cdb == 0 && between_ends(c, d, b));
}

/// All corners lie on one line, within kFlatPolygon of their extent.
bool flat(const std::vector<Corner>& corners) {
  const Corner& from = corners.front();
  const Corner& far = *std::max_element(
      corners.begin(), corners.end(),
      [&](const Corner& a, const Corner& b) { return distance(from, a) < distance(from, b); });
  const double length = distance(from, far);
  return std::all_of(corners.begin(), corners.end(), [&](const Corner& c) {
    return std::abs(turn(from, far, c)) <= kFlatPolygon * length * length;
  });
}

std::string numbered(std::size_t index) { return std::to_string(index + 1); }

}  // namespace

std::optional<PolygonFault> polygon_fault(const std::vector<Corner>& corners) {
  const std::size_t count = corners.size();
  assert(count >= 3);
  const auto corner = [&](std::size_t i) -> const Corner& { return corners[i % count]; };
  for (std::size_t i = 0; i + 1 < count; ++i)
    if (corners[i] == corners[i + 1])
      return PolygonFault{i + 1, "the same corner as number " + numbered(i) + "; leave one out"};
  if (corners.front() == corners.back())
    return PolygonFault{count - 1,
                        "the same corner as number 1; the boundary closes by itself, leave it out"};
  if (flat(corners)) return PolygonFault{0, "all corners lie on one line; expected a boundary with an area"};
  for (std::size_t i = 0; i < count; ++i) {
    const Corner &a = corner(i), &b = corner(i + 1), &c = corner(i + 2);
    const double along = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
    if (turn(a, b, c) == 0.0 && along < 0.0)
      return PolygonFault{(i + 1) % count, "the boundary turns back on itself here"};
  }
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 2; j < count; ++j) {
      if (i == 0 && j == count - 1) continue;  // neighbours across the end of the list
      if (meet(corner(i), corner(i + 1), corner(j), corner(j + 1)))
        return PolygonFault{i, "the edge from corner " + numbered(i) + " to " + numbered(i + 1) +
                                   " crosses or touches the edge from corner " + numbered(j) + " to " +
                                   numbered((j + 1) % count)};
    }
  return std::nullopt;
}

}  // namespace tiltfeed::config
