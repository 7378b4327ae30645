#pragma once
// The surfaces of the CAD files that tests/cad/cad_files.cpp writes, in closed form.

#include <algorithm>
#include <array>
#include <cmath>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::cad_shapes {

inline constexpr double kCylinderRadius = 20.0, kSphereRadius = 20.0, kTorusMajor = 20.0, kTorusMinor = 5.0;
/// Flat rings. One is narrower than chords of its circles are off them in a coarse mesh.
inline constexpr double kRingOuter = 20.02, kRingInner = 20.0, kWasherInner = 5.0;
inline constexpr double kConeLower = 15.0;  // radius at z = 0; 5 at z = 20
inline constexpr int kMixedGreen = 0x80;

/// A Bezier patch over [0, 30] x [0, 30]: x = 30 u, y = 30 v, z of these heights.
inline constexpr int kPoles = 4;
inline constexpr double kPatchStep = 10.0;
inline constexpr double kPoleHeight[kPoles][kPoles] = {
    {0, 6, -4, 2}, {5, -8, 9, 0}, {-3, 7, -6, 8}, {1, 0, 5, -2}};

inline std::array<double, kPoles> bernstein(double t) {
  const double s = 1.0 - t;
  return {s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t};
}
inline double patch_height(double x, double y) {
  const auto a = bernstein(x / 30.0), b = bernstein(y / 30.0);
  double z = 0.0;
  for (std::size_t i = 0; i < kPoles; ++i)
    for (std::size_t j = 0; j < kPoles; ++j) z += a[i] * b[j] * kPoleHeight[i][j];
  return z;
}

}  // namespace tiltfeed::cad_shapes
