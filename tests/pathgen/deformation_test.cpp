// Round trips, handedness, the axis field and the true lengths of the deformation, against closed forms and
// finite differences.
#include "pathgen/axis/deformation.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "kinematics/basics/units.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kScaleRadius = 55.0;

std::vector<AxisFrame> frames() {
  std::vector<AxisFrame> all;
  const Vec3 t = normalized(Vec3{0.3, -0.5, 0.81});
  const Vec3 n = normalized(cross(t, Vec3{0.2, 0.9, -0.1}));
  for (AxisMode mode : {AxisMode::kFixed, AxisMode::kPoint, AxisMode::kLine, AxisMode::kCircle})
    for (Sense sense : {Sense::kOutward, Sense::kInward}) {
      if (mode == AxisMode::kFixed && sense == Sense::kInward) continue;
      all.push_back({mode, sense, {12.0, -7.0, 30.0}, t, n, mode == AxisMode::kCircle ? 280.0 : 0.0});
    }
  return all;
}

/// A point whose flat coordinates are away from the seam, the poles and rho = 0.
Point<Flat> random_flat(const Deformation& map, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double rho = 50.0 + 40.0 * unit(random);
  return {1.4 * unit(random) * map.scale_x(), 1.4 * unit(random) * map.scale_y(), map.s() * rho};
}

// (deformation.h, property 1)
TEST(Deformation, RoundTripBothWays) {
  std::mt19937 random(1);
  for (const AxisFrame& frame : frames()) {
    const Deformation map(frame, kScaleRadius);
    for (int i = 0; i < 20000; ++i) {
      const Point<Flat> f = random_flat(map, random);
      const Point<Part> p = map.unflatten(f);
      EXPECT_LT(distance(map.flatten(p), f), 1e-10);
      EXPECT_LT(distance(map.unflatten(map.flatten(p)), p), 1e-10);
    }
  }
}

// (deformation.h, properties 2 and 3)
TEST(Deformation, IsRightHandedAndZGrowsAlongTheAxis) {
  std::mt19937 random(2);
  const double h = 1e-5;
  for (const AxisFrame& frame : frames()) {
    const Deformation map(frame, kScaleRadius);
    for (int i = 0; i < 500; ++i) {
      const Point<Flat> f = random_flat(map, random);
      const Vec3 dx = (map.unflatten({f.x + h, f.y, f.z}) - map.unflatten({f.x - h, f.y, f.z})) / (2 * h);
      const Vec3 dy = (map.unflatten({f.x, f.y + h, f.z}) - map.unflatten({f.x, f.y - h, f.z})) / (2 * h);
      const Vec3 dz = (map.unflatten({f.x, f.y, f.z + h}) - map.unflatten({f.x, f.y, f.z - h})) / (2 * h);
      EXPECT_GT(dot(cross(dx, dy), dz), 0.0);
      EXPECT_LT(length(dz - map.axis_at(map.unflatten(f))), 1e-8);
      EXPECT_NEAR(length(dz), 1.0, 1e-8);
      EXPECT_NEAR(dot(dx, dz), 0.0, 1e-7);
      EXPECT_NEAR(dot(dy, dz), 0.0, 1e-7);
    }
  }
}

/// Places near enough to p that no coordinate is past a seam or a pole; in all directions, mostly at the full
/// radius, where the remainder is largest.
// (deformation.h, property 5)
TEST(Deformation, TheTangentIsOffByNoMoreThanTheBend) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (AxisFrame frame : frames())
    for (const double circle : {280.0, 90.0}) {
      if (frame.mode == AxisMode::kCircle) frame.circle_radius = circle;
      const Deformation map(frame, kScaleRadius);
      double most_x = 0.0, most_y = 0.0, most_z = 0.0;  // of the bound
      for (int i = 0; i < 4000; ++i) {
        const Point<Part> p = map.unflatten(random_flat(map, random));
        const Deformation::Tangent at = map.tangent(p);
        const Deformation::Distances from = map.distances(p);
        EXPECT_LT(length(at.aim.axis - map.axis_at(p)), 1e-12);
        if (frame.mode == AxisMode::kFixed) continue;
        EXPECT_DOUBLE_EQ(at.aim.away.rho, from.rho);
        const double radius = 0.2 * std::min(from.rho, from.r) * std::abs(unit(random));
        const Deformation::Bend bend = map.bend({from.rho - radius, from.r - radius}, radius);
        for (int k = 0; k < 60; ++k) {
          const Vec3 d = normalized(Vec3{unit(random), unit(random), unit(random)}) *
                         (k % 4 == 0 ? radius * std::abs(unit(random)) : radius);
          const Point<Flat> image = map.flatten(p + d), middle = map.flatten(p);
          if (std::abs(image.x - middle.x) > 0.5 * map.scale_x() && map.period_x() > 0.0) continue;
          const double x = std::abs(image.x - middle.x - dot(at.x, d)),
                       y = std::abs(image.y - middle.y - dot(at.y, d)),
                       z = std::abs(image.z - middle.z - dot(at.aim.axis, d));
          EXPECT_LE(x, bend.x + 1e-10);
          EXPECT_LE(y, bend.y + 1e-10);
          EXPECT_LE(z, bend.z + 1e-10);
          if (bend.x > 1e-6) most_x = std::max(most_x, x / bend.x);
          most_y = std::max(most_y, y / bend.y), most_z = std::max(most_z, z / bend.z);
        }
      }
      if (frame.mode == AxisMode::kFixed) continue;
      EXPECT_GT(most_y, 0.4) << "a bound that says nothing";
      EXPECT_GT(most_z, 0.4);
      EXPECT_GT(most_x, frame.mode == AxisMode::kLine ? -1.0 : 0.4);
    }
}

TEST(Deformation, TrueLengthsOfAUnitStep) {
  std::mt19937 random(3);
  const double h = 1e-5;
  for (const AxisFrame& frame : frames()) {
    const Deformation map(frame, kScaleRadius);
    for (int i = 0; i < 200; ++i) {
      const Point<Flat> f = random_flat(map, random);
      const double rho = std::abs(f.z), phi = f.y / kScaleRadius;
      double want_x = 1.0, want_y = 1.0;
      if (frame.mode == AxisMode::kPoint)
        want_x = rho * std::cos(phi) / kScaleRadius, want_y = rho / kScaleRadius;
      if (frame.mode == AxisMode::kLine) want_y = rho / kScaleRadius;
      if (frame.mode == AxisMode::kCircle)
        want_x = (280.0 + rho * std::cos(phi)) / (280.0 + kScaleRadius), want_y = rho / kScaleRadius;
      EXPECT_NEAR(distance(map.unflatten({f.x + h, f.y, f.z}), map.unflatten({f.x - h, f.y, f.z})) / (2 * h),
                  want_x, 1e-7);
      EXPECT_NEAR(distance(map.unflatten({f.x, f.y + h, f.z}), map.unflatten({f.x, f.y - h, f.z})) / (2 * h),
                  want_y, 1e-7);
    }
  }
}

// (deformation.h, property 4)
TEST(Deformation, AxisPointsAsTheSenseSays) {
  const Point<Part> p{60.0, 35.0, -20.0};
  for (const AxisFrame& frame : frames()) {
    const Deformation map(frame, kScaleRadius);
    const Vec3 d = p - frame.origin;
    Vec3 away = d;
    if (frame.mode == AxisMode::kLine) away = d - frame.t * dot(d, frame.t);
    if (frame.mode == AxisMode::kCircle) {
      const Vec3 in_plane = d - map.b() * dot(d, map.b());
      away = d - normalized(in_plane) * 280.0;
    }
    if (frame.mode == AxisMode::kFixed) away = frame.n;
    const Vec3 want =
        normalized(away) * (frame.mode == AxisMode::kFixed ? 1.0 : static_cast<int>(frame.sense));
    EXPECT_LT(length(map.axis_at(p) - want), 1e-12);
  }
}

// A tool runs along its own axis line up to the column's end and over it.
TEST(Deformation, AToolIsAstrayPastTheEndOfItsColumn) {
  std::mt19937 random(5);
  for (const AxisFrame& frame : frames()) {
    const Deformation map(frame, kScaleRadius);
    const bool ends = frame.mode == AxisMode::kCircle && frame.sense == Sense::kOutward;
    for (int i = 0; i < 20; ++i) {
      Point<Flat> f = random_flat(map, random);
      if (ends) f.y = (f.y < 0.0 ? -1.0 : 1.0) * 2.5 * map.scale_y();  // from the inner half
      const Point<Part> p = map.unflatten(f);
      const Vec3 axis = map.axis_at(p);
      const auto end = map.column_end(f.x, f.y);
      const double rest = end && ends ? length(*end - p) : 1e3;
      EXPECT_FALSE(map.is_astray(p + axis * (0.99 * rest * (map.s() > 0.0 ? 1.0 : 0.0)), axis));
      if (ends) EXPECT_TRUE(map.is_astray(p + axis * (1.01 * rest), axis));
    }
  }
}

}  // namespace
}  // namespace tiltfeed
