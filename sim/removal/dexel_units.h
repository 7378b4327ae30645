#pragma once
// Lengths of dexels as whole units, and coordinates by number.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::sim {

/// mm; 32 bits reach 21 m.
inline constexpr double kDexelUnit = 1e-5;

inline constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min() / 2,
                              kHighest = std::numeric_limits<std::int32_t>::max() / 2;

inline double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
inline double component(Point<Part> p, int axis) { return component(from_origin(p), axis); }

inline std::int32_t to_units(double mm) {
  const double units = std::clamp(mm / kDexelUnit, 1.0 * kLowest, 1.0 * kHighest);
  return static_cast<std::int32_t>(units >= 0.0 ? units + 0.5 : units - 0.5);
}

}  // namespace tiltfeed::sim
