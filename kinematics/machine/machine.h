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
#include "kinematics/machine/machine_model.h"

namespace tiltfeed {

/// What stands in a model for an axis that the machine does not have. `direction`: any that is no other
/// axis's.
RotaryAxis absent_axis(Vec3 direction);

/// Where the tool is: (K1) with the work offset of (K2).
/// Properties: 1 forward() of either solution of inverse() is the pose: the tip within 1e-9 mm, the axis
/// within 2e-12. 2 Away from the pole there is no third solution, but for whole turns. 3 At the pole, within
/// kAtPole, C is `c_at_pole` and both solutions agree. 4 With both rotaries at home program coordinates are
/// part coordinates turned by `fixture`: within 1e-12 mm. 5 counted_turn() undoes control_word(), from any
/// turn: within 1e-9 degrees.
Pose forward(const MachineModel& machine, const Setup& setup, const Joints& joints);

/// Both solutions of (K3)/(K4)/(K5), each with C in (-180, 180] and no limits applied; first the one whose
/// tilt turns the tool counter-clockwise about the tilt's direction from where the tool is nearest to the
/// rotary axis. At the pole the axis is parallel to the rotary's, and C is free; `c_at_pole`: degrees, the
/// word. Errors: kUnreachable when no tilt gives the axis, with the axis and the reach.
Result<std::array<Joints, 2>> inverse(const MachineModel& machine, const Setup& setup, const Pose& pose,
                                      double c_at_pole);

/// The linear axes for a pose with the rotary words given (K9: solve X Y Z from rounded angles). The tip is
/// exact; the axis is whatever the rotaries make it.
Joints solve_linear(const MachineModel& machine, const Setup& setup, Point<Part> tip, double a, double c);

/// The word with which a control turns an axis from `from` to `to`, degrees with turns counted: modulo 360
/// and signed as its counting wants it. Requires: `to` rounded to `decimals`; modulo 360, less than a turn
/// away, for kShortest less than half a turn; for kSigned not a multiple of 360, which has no sign.
double control_word(RotaryWord counting, double to, double from, int decimals);
/// Where an axis at `from` goes when the control reads `word`, turns counted.
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
