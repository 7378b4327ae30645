#include "kinematics/machine/chain.h"

#include <algorithm>
#include <cassert>

namespace tiltfeed {
namespace {

// A direction this near to square (its cosine) is square: what a profile's 15 digits mean.
constexpr double kPerpendicular = 1e-12;
// How far an axis may lie beyond the reach (rad) by rounding alone.
constexpr double kReachRounding = 1e-12;
// Directions of a profile are unit to this; two that are nearer to parallel turn about the same axis.
constexpr double kUnit = 1e-9;

/// Degrees of the word to radians of the tool against the work.
double radians_per_degree(const RotaryAxis& axis, bool under_work) {
  return axis.sign * (kPi / 180.0) * (under_work ? -1.0 : 1.0);
}

bool vertical(const MachineModel& machine) {
  const Vec3 n = machine.rotary.direction;
  return machine.structure == Structure::kTableHead && n.x == 0.0 && n.y == 0.0 &&
         machine.spindle == Vec3{0.0, 0.0, 1.0};
}

ChainKind kind_of(const MachineModel& machine) {
  if (vertical(machine)) return ChainKind::kVertical;
  switch (machine.structure) {
    case Structure::kTableTable:
      return ChainKind::kTableTable;
    case Structure::kHeadHead:
      return ChainKind::kHeadHead;
    case Structure::kTableHead:
      break;
  }
  return ChainKind::kTableHead;
}

}  // namespace

Chain::Chain(const MachineModel& machine, const Setup& setup)
    : kind_(kind_of(machine)),
      has_tilt_(machine.tilt.present),
      has_rotary_(machine.rotary.present),
      square_(kind_ == ChainKind::kVertical && std::abs(machine.tilt.direction.z) < kPerpendicular),
      tilt_direction_(machine.tilt.direction),
      rotary_direction_(kind_ == ChainKind::kVertical ? Vec3{0.0, 0.0, 1.0} : machine.rotary.direction),
      pivot_to_tip_(machine.pivot_to_gauge - machine.spindle * setup.tool_length),
      lever_(turned(tilt_direction_, pivot_to_tip_)),
      tool_(turned(tilt_direction_, machine.spindle)),
      offset_(machine.rotary_to_tilt),
      part_zero_(setup.part_zero),
      fixture_(setup.fixture),
      fixture_back_(transposed(setup.fixture)),
      tilt_scale_(radians_per_degree(machine.tilt, machine.structure == Structure::kTableTable)),
      tilt_zero_(machine.tilt.zero),
      rotary_scale_(radians_per_degree(machine.rotary, machine.structure != Structure::kHeadHead)),
      rotary_zero_(machine.rotary.zero) {
  const Vec3 nC = rotary_direction_, nT = tilt_direction_, e = machine.spindle;
  assert(std::abs(length(nT) - 1.0) < kUnit && std::abs(length(machine.rotary.direction) - 1.0) < kUnit);
  assert(length(cross(nC, nT)) > kUnit && length(cross(nT, e)) > kUnit);
  if (kind_ == ChainKind::kVertical && machine.rotary.direction.z < 0.0) rotary_scale_ = -rotary_scale_;
  const Vec3 square = std::abs(nC.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  azimuth_x_ = normalized(square - nC * dot(nC, square));
  azimuth_y_ = cross(nC, azimuth_x_);
  // (K5): the tool is nearest to nC at alpha0 = atan2(b, a), and farthest from it opposite to that.
  nearest_tilt_ = std::atan2(dot(nC, tool_.cross), dot(nC, tool_.across));
  const Vec3 nearest = tool_.at(Trig::of(nearest_tilt_)), farthest = tool_.at(Trig::of(nearest_tilt_ + kPi));
  least_chord2_ = squared_length(nearest - nC);
  other_chord2_ = squared_length(farthest + nC);
  tool_azimuth_ = {std::atan2(tool_.cross.y, tool_.cross.x), std::atan2(-tool_.cross.y, -tool_.cross.x)};
  least_off_ = angle_between(nearest, nC);
  greatest_off_ = angle_between(farthest, nC);
}

Pose Chain::pose(Vec3 linear, Trig tilt, Trig rotary) const {
  const auto on_part = [&](const Held<Vec3>& on_table) -> Pose {
    const Vec3 tip = fixture_back_ * (on_table.tip - part_zero_);
    return {{tip.x, tip.y, tip.z}, fixture_back_ * on_table.axis};
  };
  switch (kind_) {
    case ChainKind::kVertical:
      return on_part(held<ChainKind::kVertical>(linear, tilt, rotary));
    case ChainKind::kTableTable:
      return on_part(held<ChainKind::kTableTable>(linear, tilt, rotary));
    case ChainKind::kHeadHead:
      return on_part(held<ChainKind::kHeadHead>(linear, tilt, rotary));
    case ChainKind::kTableHead:
      break;
  }
  return on_part(held<ChainKind::kTableHead>(linear, tilt, rotary));
}

Vec3 Chain::linear(Point<Part> tip, Trig tilt, Trig rotary) const {
  const Vec3 arm = from_table_axis(tip), w = part_zero_, v = pivot_to_tip_, d = offset_;
  switch (kind_) {
    case ChainKind::kVertical:
      return turn_z(arm, reversed(rotary)) - w + v - lever_.at(tilt);
    case ChainKind::kTableTable:
      return turn(tilt_direction_, turn(rotary_direction_, arm, reversed(rotary)) - d, reversed(tilt)) + d -
             w;
    case ChainKind::kHeadHead:
      return arm - w + v + d - turn(rotary_direction_, d + lever_.at(tilt), rotary);
    case ChainKind::kTableHead:
      break;
  }
  return turn(rotary_direction_, arm, reversed(rotary)) - w + v - lever_.at(tilt);
}

double Chain::radius(Point<Part> tip) const {
  const Vec3 arm = kind_ == ChainKind::kHeadHead ? offset_ + pivot_to_tip_ : from_table_axis(tip);
  if (kind_ == ChainKind::kVertical) return std::hypot(arm.x, arm.y);
  return length(cross(rotary_direction_, arm));
}

double Chain::nearest_tilt(Vec3 axis_T, Trig rotary) const {
  const Trig back = reversed(rotary);
  const Vec3 u = kind_ == ChainKind::kVertical ? turn_z(axis_T, back) : turn(rotary_direction_, axis_T, back);
  return std::atan2(dot(tool_.cross, u), dot(tool_.across, u));
}

double Chain::azimuth(Vec3 axis) const { return std::atan2(dot(axis, azimuth_y_), dot(axis, azimuth_x_)); }

AxisSolutions Chain::solve_square(Vec3 u) const {
  AxisSolutions found;
  found.off_pole = std::sqrt(u.x * u.x + u.y * u.y);
  const double tilt = std::atan2(found.off_pole, u.z);  // (K3), (K4)
  found.angles = {{{tilt, 0.0}, {-tilt, 0.0}}};
  found.rotary_free = found.off_pole < kAtPole;
  if (found.rotary_free) return found;
  // The rotary turns the tool's azimuth to the one of the axis on the work. The tilt, square to the rotary,
  // moves the tool in a plane with z.
  const double wanted = std::atan2(u.y, u.x);
  for (std::size_t i = 0; i < 2; ++i) found.angles[i].rotary = wanted - tool_azimuth_[i];
  return found;
}

/// With an axis absent there is one posture that comes nearest to a direction.
AxisSolutions Chain::solve_fewer(Vec3 u) const {
  const Vec3 nC = rotary_direction_, home = tool_.at({});
  AxisSolutions found;
  found.off_pole = has_rotary_ ? length(cross(nC, u)) : 1.0;  // an absent rotary has no pole
  RotaryAngles at;
  if (has_rotary_) {
    found.rotary_free = std::min(found.off_pole, length(cross(nC, home))) < kAtPole;
    if (!found.rotary_free) at.rotary = azimuth(u) - azimuth(home);
  } else if (has_tilt_) {
    at.tilt = nearest_tilt(u, {});
  }
  const double missed = angle_between(turn(nC, tool_.at(Trig::of(at.tilt)), Trig::of(at.rotary)), u);
  if (missed > kReachRounding) found.missed = missed;
  found.angles = {at, at};
  return found;
}

AxisSolutions Chain::solve_axis(Vec3 axis_T) const {
  if (!has_tilt_ || !has_rotary_) return solve_fewer(axis_T);
  if (square_) return solve_square(axis_T);
  const Vec3 u = axis_T, nC = rotary_direction_;
  AxisSolutions found;
  found.off_pole = length(cross(nC, u));
  // (K5) by squared chords, exact at the pole: tan^2 of half the way from alpha0 is near / far.
  const double near = squared_length(u - nC) - least_chord2_, far = squared_length(u + nC) - other_chord2_;
  const double off = off_rotary(u), missed = std::max(least_off_ - off, off - greatest_off_);
  if (missed > kReachRounding) found.missed = missed;
  const double way = 2.0 * std::atan2(std::sqrt(std::max(0.0, near)), std::sqrt(std::max(0.0, far)));
  found.rotary_free = found.off_pole < kAtPole;
  for (std::size_t i = 0; i < 2; ++i) {
    const double tilt = nearest_tilt_ + (i == 0 ? way : -way);
    found.angles[i] = {tilt, found.rotary_free ? 0.0 : azimuth(u) - azimuth(tool_.at(Trig::of(tilt)))};
  }
  return found;
}

}  // namespace tiltfeed
