#pragma once
// What stands in a program's comments.

#include <string>
#include <string_view>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::daemon {

/// A user's text: at most 40 characters of [A-Za-z0-9 ._-], the others left out.
std::string plain(std::string_view text);
/// "1.5 0 -2", rounded to so many decimals.
std::string triple(Vec3 v, int decimals);
/// Rz Ry Rx in degrees about the table's x, y, z: what a job file states.
Vec3 fixture_degrees(const Rotation& r);
/// Whether a fixture is turned at all, by 1e-9 degrees or more.
bool turns(const Rotation& r);

}  // namespace tiltfeed::daemon
