#include "kinematics/chain.h"

#include <algorithm>
#include <cassert>

namespace tiltfeed {
namespace {

// A head axis this near to perpendicular (its z component) is perpendicular: what a profile's 15 digits mean.
constexpr double kPerpendicular = 1e-12;
// How far the half-angle sine of (K5) may pass the head's reach by rounding alone.
constexpr double kReachRounding = 1e-12;
// Directions of a profile are unit to this.
constexpr double kUnit = 1e-9;

double radians_per_degree(const RotaryAxis& axis) { return axis.sign * (kPi / 180.0); }

}  // namespace

Chain::Chain(const MachineModel& machine, const Setup& setup)
    : head_direction_(machine.tilt.direction),
      head_sine_(std::hypot(head_direction_.x, head_direction_.y)),
      perpendicular_(std::abs(head_direction_.z) < kPerpendicular),
      lever_(turned(head_direction_, machine.pivot_to_gauge + Vec3{0.0, 0.0, -setup.tool_length})),
      tool_(turned(head_direction_, {0.0, 0.0, 1.0})),
      part_zero_(setup.part_zero),
      fixture_(setup.fixture),
      fixture_back_(transposed(setup.fixture)),
      head_scale_(radians_per_degree(machine.tilt)),
      head_zero_(machine.tilt.zero),
      table_scale_(radians_per_degree(machine.rotary) * (machine.rotary.direction.z < 0.0 ? -1.0 : 1.0)),
      table_zero_(machine.rotary.zero) {
  assert(std::abs(length(head_direction_) - 1.0) < kUnit && head_sine_ > kUnit);
  assert(std::abs(std::abs(machine.rotary.direction.z) - 1.0) < kUnit);
}

Vec3 Chain::linear(Point<Part> tip, Trig head, Trig table) const {
  return turn_z(fixture_ * from_origin(tip) + part_zero_, table) - part_zero_ + lever_.v - lever_.at(head);
}

double Chain::radius(Point<Part> tip) const {
  const Vec3 arm = fixture_ * from_origin(tip) + part_zero_;
  return std::hypot(arm.x, arm.y);
}

double Chain::nearest_head(Vec3 axis_T, Trig table) const {
  const Vec3 u = turn_z(axis_T, table);
  return std::atan2(dot(tool_.cross, u), dot(tool_.v - tool_.along, u));
}

AxisSolutions Chain::solve_axis(Vec3 axis_T) const {
  const Vec3 u = axis_T;
  AxisSolutions found;
  found.off_pole = std::hypot(u.x, u.y);
  double head = 0.0;
  if (perpendicular_) {
    head = std::atan2(found.off_pole, u.z);  // (K3), (K4)
  } else {
    // (K5) with e = nC in half angles: sin(head / 2) = sin(tilt / 2) / sin(nu), exact at the pole.
    const double half = length(u - Vec3{0.0, 0.0, 1.0}) / 2.0;
    found.reachable = half <= head_sine_ + kReachRounding;
    head = 2.0 * std::atan2(half, std::sqrt(std::max(0.0, (head_sine_ - half) * (head_sine_ + half))));
  }
  found.angles = {{{head, 0.0}, {-head, 0.0}}};
  found.table_free = found.off_pole < kAtPole;
  if (found.table_free) return found;
  // The table turns the part's azimuth to the one that the head gives the tool.
  const double azimuth = std::atan2(u.y, u.x);
  const Trig turn = Trig::of(head);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3 h = tool_.at(i == 0 ? turn : reversed(turn));
    found.angles[i].table = std::atan2(h.y, h.x) - azimuth;
  }
  return found;
}

}  // namespace tiltfeed
