#pragma once
// Four boxes against a ray, in single precision.

#include <array>
#include <cstddef>

#include "kinematics/basics/lanes.h"

namespace tiltfeed::pathgen {

struct FourBoxes {
  std::array<Lanes, 3> low, high;
};

/// A ray from + t direction, first <= t <= last, how near to it what is asked for may be, and between which
/// heights.
struct RayLanes {
  std::array<Lanes, 3> low, high;  ///< from + reach, from - reach
  std::array<Lanes, 3> inverse;    ///< of the direction
  std::array<bool, 3> backwards;
  std::array<Lanes, 3> from, direction;
  Lanes first, last, reach;
  Lanes least_height, most_height;  ///< along the direction, over the middle
};

/// Which boxes have something between the ray's heights, a bit each.
inline unsigned boxes_between(const FourBoxes& boxes, const RayLanes& ray) {
  Lanes low = all_lanes(0.0f), high = low;
  for (std::size_t k = 0; k < 3; ++k) {
    const Lanes a = boxes.low[k] * ray.direction[k], b = boxes.high[k] * ray.direction[k];
    low += ray.backwards[k] ? b : a;
    high += ray.backwards[k] ? a : b;
  }
  return no_more(ray.least_height, high) & no_more(low, ray.most_height);
}

/// Which boxes, wider by the reach to all sides, the ray meets, a bit each, and at which t.
inline unsigned boxes_met(const FourBoxes& boxes, const RayLanes& ray, Lanes& entry) {
  Lanes in = ray.first, out = ray.last;
  for (std::size_t k = 0; k < 3; ++k) {
    const Lanes a = (boxes.low[k] - ray.low[k]) * ray.inverse[k],
                b = (boxes.high[k] - ray.high[k]) * ray.inverse[k];
    in = greater(in, ray.backwards[k] ? b : a);
    out = lesser(out, ray.backwards[k] ? a : b);
  }
  entry = in;
  return no_more(in, out);
}

}  // namespace tiltfeed::pathgen
