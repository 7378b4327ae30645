#include <array>
#include <cmath>

#include "config/job_keys.h"

namespace tiltfeed::config {
namespace {

constexpr Range kPosition{-10'000.0, 10'000.0};  // mm
constexpr Range kFixtureAngle{-360.0, 360.0};    // degrees
constexpr Range kTilt = above(0.0, 180.0);       // degrees

/// Cosine and sine of an angle in degrees, exact for multiples of 90.
std::array<double, 2> turn(double degrees) {
  constexpr std::array<std::array<double, 2>, 4> kQuarters{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const double quarters = degrees / 90.0;
  if (quarters == std::floor(quarters)) return kQuarters[(static_cast<int>(quarters) % 4 + 4) % 4];
  const double angle = Angle::from_degrees(degrees).radians();
  return {std::cos(angle), std::sin(angle)};
}

/// Rz Ry Rx: about the table's x first, then its y, then its z.
Rotation fixture_rotation(Vec3 degrees) {
  const auto [cx, sx] = turn(degrees.x);
  const auto [cy, sy] = turn(degrees.y);
  const auto [cz, sz] = turn(degrees.z);
  const Rotation about_x{{Vec3{1, 0, 0}, Vec3{0, cx, -sx}, Vec3{0, sx, cx}}};
  const Rotation about_y{{Vec3{cy, 0, sy}, Vec3{0, 1, 0}, Vec3{-sy, 0, cy}}};
  const Rotation about_z{{Vec3{cz, -sz, 0}, Vec3{sz, cz, 0}, Vec3{0, 0, 1}}};
  return about_z * about_y * about_x;
}

}  // namespace

Setup read_setup(const Section& root, pathgen::PlanOptions& plan) {
  const Section section = root.section("setup", {"part_zero_mm", "fixture_rotation_deg", "tilt_max_deg"});
  Setup setup;
  setup.part_zero = section.vector("part_zero_mm", kPosition);
  setup.fixture = fixture_rotation(section.vector("fixture_rotation_deg", kFixtureAngle, Vec3{}));
  setup.tool_length = plan.cutter.length;
  plan.up = setup.fixture.rows[2];
  plan.tilt_max = Angle::from_degrees(section.number("tilt_max_deg", kTilt, plan.tilt_max.degrees()));
  return setup;
}

}  // namespace tiltfeed::config
