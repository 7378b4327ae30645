#pragma once
// The frame that the spindle has with its rotaries at given words, and angles that state such a frame to a
// control. (K14).

#include <array>

#include "kinematics/basics/geometry.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed {

/// Directions of the spindle's frame to those of the work as it stands with the rotaries at home: its z is
/// the tool axis, its x and y are the machine's where the head is at home. A rotation within 1e-14.
Rotation spindle_frame(const MachineModel& machine, double a, double c);

/// Angles of a rotation in degrees, each about an axis that the ones before have turned.
using PlaneAngles = std::array<double, 3>;

/// About z, x, z (G68.2), the second in [0, 180]; where it is 0 or 180 the third is 0.
PlaneAngles zxz_angles(const Rotation& frame);
Rotation from_zxz(const PlaneAngles& angles);
/// About z, y, x (PLANE SPATIAL, CYCLE800), the second in [-90, 90]; where it is an end the third is 0.
PlaneAngles zyx_angles(const Rotation& frame);
Rotation from_zyx(const PlaneAngles& angles);

}  // namespace tiltfeed
