#pragma once
// Text of a job file.

#include <string>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::attack {

/// As printf, up to 511 characters.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);
/// `key: [x, y, z]` as a line.
std::string vector(const char* key, Vec3 v);
/// `key: [low, high]` as a line of a section.
std::string interval(const char* key, double low, double high);

}  // namespace tiltfeed::attack
