#pragma once
// One machine with one set-up as formulas: the constants of (K1)..(K5) worked out once, angles as cosine and
// sine, so that a block can be sampled without trigonometric calls.
// Angles, in rad, turn the tool against the work: counter-clockwise about the axis's direction where the axis
// is in the head, clockwise where it is under the work. So the tool axis is R(nC, rotary) R(nT, tilt) e on
// the work, whatever the structure.

#include <array>
#include <cmath>

#include "kinematics/basics/lanes.h"
#include "kinematics/basics/tool_path.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed {

/// A rotation angle as its cosine and sine.
struct Trig {
  double cos = 1.0, sin = 0.0;
  static Trig of(double radians) { return {std::cos(radians), std::sin(radians)}; }
};
/// The sum of two angles.
constexpr Trig operator*(Trig a, Trig b) {
  return {a.cos * b.cos - a.sin * b.sin, a.sin * b.cos + a.cos * b.sin};
}

constexpr Trig reversed(Trig t) { return {t.cos, -t.sin}; }

/// Two angles.
struct TwinTrig {
  Twin cos, sin;
};
inline TwinTrig beside(Trig a, Trig b) { return {Twin{a.cos, b.cos}, Twin{a.sin, b.sin}}; }
inline TwinTrig operator*(TwinTrig a, TwinTrig b) {
  return {a.cos * b.cos - a.sin * b.sin, a.sin * b.cos + a.cos * b.sin};
}

/// The vector turned about +z; one or two.
template <class Vector, class Angle>
constexpr Vector turn_z(Vector v, Angle t) {
  return {t.cos * v.x - t.sin * v.y, t.sin * v.x + t.cos * v.y, v.z};
}
/// The vector turned about the unit vector `n` [Rodrigues].
template <class Vector, class Angle>
constexpr Vector turn(Vec3 n, Vector v, Angle t) {
  return v * t.cos + cross(n, v) * t.sin + n * (dot(n, v) * (1.0 - t.cos));
}

/// Angles of both rotaries, rad.
struct RotaryAngles {
  double tilt = 0.0, rotary = 0.0;
};

/// Nearer to the rotary axis than this (rad) the rotary's angle has no meaning in a double: "at the pole".
inline constexpr double kAtPole = 1e-12;

/// The rotary angles that give a tool axis.
struct AxisSolutions {
  double off_pole = 0.0;                 ///< sine of the angle between the tool axis and the rotary's
  double missed = 0.0;                   ///< how far the axis lies beyond the reach, rad; 0: reached
  bool rotary_free = false;              ///< at the pole: any rotary angle does, here 0
  std::array<RotaryAngles, 2> angles{};  ///< for a missed axis: the nearest that is reached
};

/// Joints, and their angles as cosine and sine.
struct Posture {
  Joints joints;
  Trig tilt, rotary;
};

/// The formulas that a chain needs.
enum class ChainKind {
  kVertical,  ///< kTableHead whose table turns about z and whose spindle is z: fewer terms
  kTableHead,
  kTableTable,
  kHeadHead,
};

class Chain {
 public:
  /// Requires: directions unit, those of the rotaries and of tilt and spindle not parallel.
  Chain(const MachineModel& machine, const Setup& setup);

  double tilt_radians(double a) const { return (a - tilt_zero_) * tilt_scale_; }
  double rotary_radians(double c) const { return (c - rotary_zero_) * rotary_scale_; }
  /// The words, degrees, of angles.
  double tilt_word(double radians) const { return radians / tilt_scale_ + tilt_zero_; }
  double rotary_word(double radians) const { return radians / rotary_scale_ + rotary_zero_; }
  Trig tilt_trig(double a) const { return Trig::of(tilt_radians(a)); }
  Trig rotary_trig(double c) const { return Trig::of(rotary_radians(c)); }

  ChainKind kind() const { return kind_; }
  /// (K1), (K2) forward. `linear`: the X Y Z words.
  Pose pose(Vec3 linear, Trig tilt, Trig rotary) const;
  /// The tip from the rotary table's axis and the tool axis, as the table sees them.
  template <class Vector>
  struct Held {
    Vector tip, axis;
  };
  /// The same on the table for the chain's own kind, which the caller tells; one or two poses.
  template <ChainKind kind, class Vector, class Angle>
  Held<Vector> held(Vector linear, Angle tilt, Angle rotary) const;  // inline below
  /// (K2): the X Y Z words that put the tip there.
  Vec3 linear(Point<Part> tip, Trig tilt, Trig rotary) const;

  Vec3 from_table_axis(Point<Part> tip) const { return fixture_ * from_origin(tip) + part_zero_; }
  /// RW u: a part direction as the work sees it at home.
  Vec3 on_table(Vec3 direction_P) const { return fixture_ * direction_P; }
  /// (K3)..(K5): both rotary solutions of an axis on the work; where an axis is absent they are one, with it
  /// at home.
  AxisSolutions solve_axis(Vec3 axis_T) const;
  /// The tilt angle whose tool axis comes nearest to `axis_T` when the rotary stands at `rotary`.
  double nearest_tilt(Vec3 axis_T, Trig rotary) const;
  /// Angle between a direction and the rotary axis, rad; its least and greatest for tool axes.
  double off_rotary(Vec3 axis_T) const { return angle_between(axis_T, rotary_direction_); }
  std::array<double, 2> reach() const { return {least_off_, greatest_off_}; }
  /// Distance of the tip (of the work or, for head-head, of the tool) from the rotary's axis, mm.
  double radius(Point<Part> tip) const;

 private:
  /// A vector v to be turned about n: n (n.v), v - n (n.v), n x v.
  struct Turned {
    Vec3 along, across, cross;
    /// What of R(n, angle) v changes with the angle; `along` is to be added.
    template <class Angle>
    auto swing(Angle t) const {
      return across * t.cos + cross * t.sin;
    }
    Vec3 at(Trig t) const { return along + swing(t); }
  };
  static Turned turned(Vec3 n, Vec3 v) { return {n * dot(n, v), v - n * dot(n, v), cross(n, v)}; }
  AxisSolutions solve_square(Vec3 axis_T) const;
  AxisSolutions solve_fewer(Vec3 axis_T) const;
  double azimuth(Vec3 axis) const;

  ChainKind kind_;
  bool has_tilt_, has_rotary_;
  bool square_;  ///< kVertical, and the tilt's direction square to z
  Vec3 tilt_direction_, rotary_direction_;
  Vec3 pivot_to_tip_;  ///< v
  Turned lever_;       ///< v
  Turned tool_;        ///< e, the tool axis at home
  Vec3 offset_;        ///< d, rotary axis to tilt axis
  Vec3 part_zero_;
  Rotation fixture_, fixture_back_;
  double tilt_scale_, tilt_zero_, rotary_scale_, rotary_zero_;
  Vec3 azimuth_x_, azimuth_y_;          ///< unit, square to the rotary axis
  std::array<double, 2> tool_azimuth_;  ///< of a square head tilted either way
  double nearest_tilt_;                 ///< where the tool is nearest to the rotary axis
  double least_chord2_, other_chord2_;  ///< squared: tool there to nC; the tool opposite to -nC
  double least_off_, greatest_off_;
};

template <ChainKind kind, class Vector, class Angle>
inline Chain::Held<Vector> Chain::held(Vector linear, Angle tilt, Angle rotary) const {
  const Vec3 w = part_zero_, v = pivot_to_tip_, d = offset_, nC = rotary_direction_;
  const Vector tool = tool_.along + tool_.swing(tilt);
  const Vector under_head = linear + (w - v + lever_.along) + lever_.swing(tilt);
  if constexpr (kind == ChainKind::kVertical) return {turn_z(under_head, rotary), turn_z(tool, rotary)};
  const Vector axis = turn(nC, tool, rotary);
  if constexpr (kind == ChainKind::kTableTable)
    return {turn(nC, d + turn(tilt_direction_, linear + (w - d), tilt), rotary), axis};
  if constexpr (kind == ChainKind::kHeadHead)
    return {linear + (w - v - d) + turn(nC, (d + lever_.along) + lever_.swing(tilt), rotary), axis};
  return {turn(nC, under_head, rotary), axis};
}

}  // namespace tiltfeed
