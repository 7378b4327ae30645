#pragma once
// One machine with one set-up as formulas: the constants of (K1)..(K5) worked out once, angles as cosine and
// sine, so that a block can be sampled without trigonometric calls.
// Physical angles are in rad: `head` (alpha) about the head's direction, `table` (phi) about +z.

#include <array>
#include <cmath>

#include "kinematics/machine.h"

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
/// The vector turned about +z.
constexpr Vec3 turn_z(Vec3 v, Trig t) { return {t.cos * v.x - t.sin * v.y, t.sin * v.x + t.cos * v.y, v.z}; }

/// Physical rotary angles, rad.
struct RotaryAngles {
  double head = 0.0, table = 0.0;
};

/// Nearer to the table's axis than this (rad) the table angle has no meaning in a double: "at the pole".
inline constexpr double kAtPole = 1e-12;

/// The rotary angles that give a tool axis.
struct AxisSolutions {
  double off_pole = 0.0;                 ///< sine of the angle between the tool axis and the table's
  bool reachable = true;                 ///< by the head; else the angles mean nothing
  bool table_free = false;               ///< at the pole: any table angle does, here 0
  std::array<RotaryAngles, 2> angles{};  ///< the one with head >= 0 first
};

/// Joints, and their physical rotary angles as cosine and sine.
struct Posture {
  Joints joints;
  Trig head, table;
};

class Chain {
 public:
  /// Requires: directions unit; the table's vertical, the head's not.
  Chain(const MachineModel& machine, const Setup& setup);

  double head_radians(double a) const { return (a - head_zero_) * head_scale_; }
  double table_radians(double c) const { return (c - table_zero_) * table_scale_; }
  /// The words, degrees, of physical angles.
  double head_word(double radians) const { return radians / head_scale_ + head_zero_; }
  double table_word(double radians) const { return radians / table_scale_ + table_zero_; }
  Trig head_trig(double a) const { return Trig::of(head_radians(a)); }
  Trig table_trig(double c) const { return Trig::of(table_radians(c)); }

  /// (K1), (K2) forward. `linear`: the X Y Z words.
  Pose pose(Vec3 linear, Trig head, Trig table) const;  // inline below: sampled in vector code
  /// (K2): the X Y Z words that put the tip there.
  Vec3 linear(Point<Part> tip, Trig head, Trig table) const;

  /// RW u: a part direction on the table at table zero.
  Vec3 on_table(Vec3 direction_P) const { return fixture_ * direction_P; }
  /// (K3)..(K5): both rotary solutions of an axis on the table.
  AxisSolutions solve_axis(Vec3 axis_T) const;
  /// The head angle whose tool axis comes nearest to `axis_T` when the table stands at `table`.
  double nearest_head(Vec3 axis_T, Trig table) const;
  /// Largest angle between tool axis and table axis that the head can make, rad.
  double reach() const { return 2.0 * std::asin(head_sine_); }
  /// Distance of the tip from the table's axis, mm.
  double radius(Point<Part> tip) const;

 private:
  /// R(nH, alpha) applied to the vector with these three parts: v, nH x v, nH (nH.v).
  struct Turned {
    Vec3 v, cross, along;
    Vec3 at(Trig t) const { return v * t.cos + cross * t.sin + along * (1.0 - t.cos); }
  };
  static Turned turned(Vec3 n, Vec3 v) { return {v, cross(n, v), n * dot(n, v)}; }

  Vec3 head_direction_;
  double head_sine_;  ///< of the angle between head and table axis
  bool perpendicular_;
  Turned lever_;  ///< v, pivot to tip
  Turned tool_;   ///< the tool axis at head zero, ez
  Vec3 part_zero_;
  Rotation fixture_, fixture_back_;
  double head_scale_, head_zero_, table_scale_, table_zero_;
};

inline Pose Chain::pose(Vec3 linear, Trig head, Trig table) const {
  const Trig back = reversed(table);
  const Vec3 tip_T = turn_z(linear + part_zero_ - lever_.v + lever_.at(head), back) - part_zero_;
  const Vec3 tip_P = fixture_back_ * tip_T;
  return {{tip_P.x, tip_P.y, tip_P.z}, fixture_back_ * turn_z(tool_.at(head), back)};
}

}  // namespace tiltfeed
