#include "kinematics/machine/spindle_frame.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/units.h"
#include "kinematics/machine/chain.h"

namespace tiltfeed {
namespace {

constexpr Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
// A sine below this is that of an angle whose other two turn about one line.
constexpr double kOneLine = 1e-9;

/// The shortest turn of z to a unit vector.
Rotation to_spindle(Vec3 spindle) {
  const Vec3 normal = cross(kZ, spindle);
  const double sine = length(normal);
  if (sine == 0.0) return spindle.z < 0.0 ? rotation_about(kX, kPi) : Rotation{};
  return rotation_about(normal * (1.0 / sine), std::atan2(sine, spindle.z));
}

Rotation about(Vec3 axis, double degrees) {
  return rotation_about(axis, Angle::from_degrees(degrees).radians());
}

double degrees(double sine, double cosine) { return Angle::from_radians(std::atan2(sine, cosine)).degrees(); }

}  // namespace

Rotation spindle_frame(const MachineModel& machine, double a, double c) {
  const Chain chain(machine, Setup{});
  return rotation_about(machine.rotary.direction, chain.rotary_radians(c)) *
         rotation_about(machine.tilt.direction, chain.tilt_radians(a)) * to_spindle(machine.spindle);
}

PlaneAngles zxz_angles(const Rotation& frame) {
  const auto& r = frame.rows;
  const double sine = std::hypot(r[0].z, r[1].z);
  if (sine < kOneLine) return {degrees(r[1].x, r[0].x), r[2].z < 0.0 ? 180.0 : 0.0, 0.0};
  return {degrees(r[0].z, -r[1].z), degrees(sine, r[2].z), degrees(r[2].x, r[2].y)};
}

Rotation from_zxz(const PlaneAngles& angles) {
  return about(kZ, angles[0]) * about(kX, angles[1]) * about(kZ, angles[2]);
}

PlaneAngles zyx_angles(const Rotation& frame) {
  const auto& r = frame.rows;
  const double cosine = std::hypot(r[0].x, r[1].x);
  if (cosine < kOneLine) return {degrees(-r[0].y, r[1].y), r[2].x < 0.0 ? 90.0 : -90.0, 0.0};
  return {degrees(r[1].x, r[0].x), degrees(-r[2].x, cosine), degrees(r[2].y, r[2].z)};
}

Rotation from_zyx(const PlaneAngles& angles) {
  return about(kZ, angles[0]) * about(kY, angles[1]) * about(kX, angles[2]);
}

}  // namespace tiltfeed
