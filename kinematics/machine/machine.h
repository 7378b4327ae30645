#pragma once
// The machine: where a joint position puts the tool on the part, and back.
// Frames: P part, M machine. Signs and zeros per rotary are profile fields, since real machines disagree.
// Equations (K1)..(K5) are in kinematics/machine/README.md.

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
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

/// What stands in a model for an axis that the machine does not have. `direction`: any that is no other
/// axis's.
RotaryAxis absent_axis(Vec3 direction);

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

/// (K1) with the work offset of (K2): program coordinates coincide with part coordinates turned by
/// `fixture`, seen with both rotaries at home. Exact inverse of `inverse`: 1e-9 mm.
Pose forward(const MachineModel& machine, const Setup& setup, const Joints& joints);

/// Both solutions of (K3)/(K4)/(K5), each with C in (-180, 180] and no limits applied; first the one whose
/// tilt turns the tool counter-clockwise about the tilt's direction from where the tool is nearest to the
/// rotary axis. At the pole (axis parallel to the rotary's within 1e-12 rad) C is free: `c_at_pole` (degrees,
/// the word) is kept and both solutions agree. Errors: kUnreachable when no tilt gives the axis, with the
/// axis and the reach.
Result<std::array<Joints, 2>> inverse(const MachineModel& machine, const Setup& setup, const Pose& pose,
                                      double c_at_pole);

/// The linear axes for a pose with the rotary words given (K9: solve X Y Z from rounded angles). The tip is
/// exact; the axis is whatever the rotaries make it.
Joints solve_linear(const MachineModel& machine, const Setup& setup, Point<Part> tip, double a, double c);

/// The word with which a control turns an axis from `from` to `to`, degrees with turns counted: modulo 360
/// and signed as its counting wants it. Requires: `to` rounded to `decimals`; modulo 360, less than a turn
/// away, for kShortest less than half a turn; for kSigned not a multiple of 360, which has no sign.
double control_word(RotaryWord counting, double to, double from, int decimals);
/// Where an axis at `from` goes when the control reads `word`, turns counted: undoes `control_word`.
double counted_turn(RotaryWord counting, double word, double from);

/// The rotary axis as a part direction, unit, pointing from the work to where the spindle is at home.
Vec3 rotary_up(const MachineModel& machine, const Setup& setup);

/// No limit is broken.
bool within_limits(const MachineModel& machine, const Joints& joints);

/// The first broken limit, rotaries first, as text ("Z -512.3 mm is below its travel of -500 mm"), or
/// nothing.
std::optional<std::string> broken_limit(const MachineModel& machine, const Joints& joints);

/// Why no tilt gives this axis: the axis as the part (`axis_P`) and the rotary table (`axis_T`) see it, the
/// reach.
std::string unreachable_text(const MachineModel& machine, Vec3 axis_P, Vec3 axis_T);

}  // namespace tiltfeed
