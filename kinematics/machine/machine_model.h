#pragma once
// A machine, its axes and the set-up on it, as data. Frames and signs: kinematics/machine/README.md.

#include <limits>
#include <string>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/units.h"

namespace tiltfeed {

/// Machine axis words: linear axes in program coordinates (K2), mm; `a` the word of `MachineModel::tilt` and
/// `c` that of `MachineModel::rotary`, degrees, whatever letters the profile gives them. Turns are counted:
/// how a control prints and takes its words is RotaryAxis::word.
struct Joints {
  double x = 0.0, y = 0.0, z = 0.0;  ///< mm
  double a = 0.0, c = 0.0;           ///< degrees
  constexpr bool operator==(const Joints&) const = default;
};

struct LinearAxis {
  double min = 0.0, max = 0.0;  ///< travel in program coordinates, mm
  double velocity = 0.0;        ///< mm/min
  double acceleration = 0.0;    ///< mm/s^2
  double jerk = 0.0;            ///< mm/s^3; 0: no limit
};

/// What a control makes of a rotary word.
enum class RotaryWord {
  kAccumulate,  ///< turns count: from 350 to 10 is 340 degrees back
  kShortest,    ///< modulo 360, the shorter way: from 350 to 10 is 20 degrees on
  kSigned,      ///< modulo 360, the sign is the way: +10 turns forward to 10, -10 back to 10
};

/// The letter of an axis that a machine does not have.
inline constexpr char kNoLetter = '-';

/// physical rotation of the body = sign * (word - zero). Role (tilt or rotary) and letter are separate.
struct RotaryAxis {
  char letter = 'A';
  Vec3 direction{1, 0, 0};      ///< unit, machine frame, all axes at zero
  int sign = +1;                ///< +1: the word turns the body counter-clockwise about `direction`
  double zero = 0.0;            ///< word at which the body is at home, degrees
  double min = 0.0, max = 0.0;  ///< limits of the word, degrees
  double velocity = 0.0;        ///< degrees/min
  double acceleration = 0.0;    ///< degrees/s^2
  double jerk = 0.0;            ///< degrees/s^3; 0: no limit
  RotaryWord word = RotaryWord::kAccumulate;
  bool present = true;  ///< false: the machine does not have it; it stands at 0 for ever and has no word
};

/// Which rotary turns the work and which the tool. From the work to the tool `rotary` always comes first.
enum class Structure {
  kTableHead,   ///< rotary under the work, tilt in the head
  kTableTable,  ///< tilt carries rotary, rotary carries the work
  kHeadHead,    ///< rotary carries tilt, tilt carries the tool
};

/// A machine with two rotary axes of any directions that are not parallel, or with one or none: then
/// kTableHead, with a table (`rotary`), a head (`tilt`) or neither. `table_centre` does not enter
/// program coordinates (K2).
struct MachineModel {
  std::string name;
  LinearAxis x, y, z;
  RotaryAxis tilt;                   ///< next to the tool; letter A, B or other
  RotaryAxis rotary;                 ///< next to the work; letter C usually
  Point<MachineSpace> table_centre;  ///< a point of the rotary table's axis, machine coordinates, mm
  Vec3 pivot_to_gauge{0, 0, 0};      ///< tilting head: pivot to gauge line at home; z is -(pivot length), mm
  Structure structure = Structure::kTableHead;
  Vec3 rotary_to_tilt{0, 0, 0};  ///< table-table, head-head: a point of the rotary axis to one of the tilt
                                 ///< axis (the pivot of a head), all axes at home, mm
  Vec3 spindle{0, 0, 1};         ///< unit, from tool tip to shank with all axes at home
  int preferred_tilt = 0;     ///< sign of the tilt from home taken where both serve; 0: whichever is quicker
  bool blends_rotary = true;  ///< the control blends blocks in which rotaries move; else each has to be long
                              ///< enough to reach its speed and to leave it again (LinuxCNC)
};

/// How the part sits on the table and how long the tool is.
struct Setup {
  Vec3 part_zero;            ///< w: from the rotary table's axis point to part zero at home, mm
  Rotation fixture;          ///< RW: part directions to table directions
  double tool_length = 0.0;  ///< gauge line to tip, mm
};

}  // namespace tiltfeed
