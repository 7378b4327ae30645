#pragma once
// Whole tools with their outline written down, poses, and planes to hold them against.

#include <algorithm>
#include <cmath>
#include <random>

#include "sim/solid/tool_solid.h"
#include "tests/shapes/facet_soup.h"

namespace tiltfeed::sim {
using namespace pathgen;

/// Of each type one with shank and holder.
inline Cutter full(CutterType type) {
  Cutter c;
  c.type = type, c.diameter = 6.0, c.length = 90.0, c.shank_length = 30.0;
  c.cutting_length = 12.0, c.shank_diameter = 5.0;
  if (type == CutterType::kBullNose) c.corner_radius = 1.25;
  if (type == CutterType::kTaperBall) c.taper = Angle::from_degrees(7.0), c.shank_diameter = 12.0;
  c.holder = {{16.0, 22.0, 10.0}, {30.0, 26.0, 8.0}};
  return c;
}
inline constexpr CutterType kTypes[] = {CutterType::kBall, CutterType::kBullNose, CutterType::kFlat,
                                        CutterType::kTaperBall};

/// The tool's radius at height h, from the words of pathgen/options/cutter.h.
inline double radius_of(const Cutter& c, double h) {
  const double r = c.diameter / 2.0;
  const auto round = [h](double e, double k) {
    return h >= k ? e + k : e + std::sqrt(std::max(0.0, h * (2 * k - h)));
  };
  if (h < c.cutting_length) {
    if (c.type == CutterType::kFlat) return r;
    if (c.type == CutterType::kBullNose) return round(r - c.corner_radius, c.corner_radius);
    if (c.type == CutterType::kBall) return round(0, r);
    const double t = c.taper.radians();
    // The cone's apex lies r / sin t below the ball's centre.
    return h < r * (1 - std::sin(t)) ? round(0, r) : (h - r + r / std::sin(t)) * std::tan(t);
  }
  if (h < c.shank_length) return c.shank_diameter / 2.0;
  double at = c.shank_length;
  for (const HolderStep& s : c.holder) {
    if (h <= at + s.length)
      return (s.lower_diameter + (s.upper_diameter - s.lower_diameter) * (h - at) / s.length) / 2.0;
    at += s.length;
  }
  return -1.0;
}

inline Vec3 random_axis(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return normalized({normal(random), normal(random), normal(random)});
}

/// Large triangle in the plane through `at` square to `normal`.
inline Mesh plane_at(Point<Part> at, Vec3 normal) {
  const Vec3 u = normalized(cross(normal, std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 v = cross(normal, u);
  return mesh_of({{at + u * 300.0, at - u * 150.0 + v * 260.0, at - u * 150.0 - v * 260.0}});
}

}  // namespace tiltfeed::sim
