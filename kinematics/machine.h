#pragma once
// The machine: where a joint position puts the tool on the part, and back.
// Frames: P part, M machine. Signs and zeros per rotary are profile fields, since real machines disagree.
// Equations (K1)..(K5) are in kinematics/README.md.

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "kinematics/geometry.h"
#include "kinematics/result.h"
#include "kinematics/tool_path.h"
#include "kinematics/units.h"

namespace tiltfeed {

/// Machine axis words: linear axes in program coordinates (K2), mm; `a` the tilting head's word and `c` the
/// rotary table's word, degrees as programmed, whatever letters the profile gives them.
struct Joints {
  double x = 0.0, y = 0.0, z = 0.0;  ///< mm
  double a = 0.0, c = 0.0;           ///< degrees
  constexpr bool operator==(const Joints&) const = default;
};

struct LinearAxis {
  double min = 0.0, max = 0.0;  ///< travel in program coordinates, mm
  double velocity = 0.0;        ///< mm/min
  double acceleration = 0.0;    ///< mm/s^2
};

/// physical rotation = sign * (word - zero). Role (tilt or rotary) and letter are separate.
struct RotaryAxis {
  char letter = 'A';
  Vec3 direction{1, 0, 0};      ///< unit, machine frame, all axes at zero
  int sign = +1;                ///< +1: the word turns the body counter-clockwise about `direction`
  double zero = 0.0;            ///< word at which the body is at home, degrees
  double min = 0.0, max = 0.0;  ///< limits of the word, degrees
  double velocity = 0.0;        ///< degrees/min
  double acceleration = 0.0;    ///< degrees/s^2
};

/// A table-rotating, head-tilting machine (table turns about the vertical, head tilts about any axis that
/// is not vertical). `table_centre` does not enter program coordinates (K2).
struct MachineModel {
  std::string name;
  LinearAxis x, y, z;
  RotaryAxis tilt;                   ///< the head; letter A, B or other
  RotaryAxis rotary;                 ///< the table; direction is vertical, letter C usually
  Point<MachineSpace> table_centre;  ///< a point of the table's axis, machine coordinates, mm
  Vec3 pivot_to_gauge{0, 0, 0};      ///< head pivot to gauge line at head zero; z is -(pivot length), mm
};

/// How the part sits on the table and how long the tool is.
struct Setup {
  Vec3 part_zero;            ///< w: from the table axis point to part zero at table zero, mm
  Rotation fixture;          ///< RW: part directions to table directions
  double tool_length = 0.0;  ///< gauge line to tip, mm
};

/// (K1) with the work offset of (K2): program coordinates coincide with part coordinates turned by
/// `fixture`, seen at table and head zero. Exact inverse of `inverse`: 1e-9 mm.
Pose forward(const MachineModel& machine, const Setup& setup, const Joints& joints);

/// Both solutions of (K3)/(K4)/(K5), the one with the physical head angle >= 0 first, each with C in (-180,
/// 180] and no limits applied. At the pole (axis parallel to the table's axis within 1e-12 rad) C is free:
/// `c_at_pole` (degrees, the word) is kept and both solutions agree. Errors: kUnreachable when no head angle
/// gives the axis (nutating heads), with the axis and the reach.
Result<std::array<Joints, 2>> inverse(const MachineModel& machine, const Setup& setup, const Pose& pose,
                                      double c_at_pole);

/// The linear axes for a pose with the rotary words given (K9: solve X Y Z from rounded angles). The tip is
/// exact; the axis is whatever the rotaries make it.
Joints solve_linear(const MachineModel& machine, const Setup& setup, Point<Part> tip, double a, double c);

/// No limit is broken.
bool within_limits(const MachineModel& machine, const Joints& joints);

/// The first broken limit, rotaries first, as text ("Z -512.3 mm is below its travel of -500 mm"), or
/// nothing.
std::optional<std::string> broken_limit(const MachineModel& machine, const Joints& joints);

/// Why no head angle gives this axis: the axis as the part (`axis_P`) and the table (`axis_T`) see it, the
/// reach.
std::string unreachable_text(const MachineModel& machine, Vec3 axis_P, Vec3 axis_T);

}  // namespace tiltfeed
