#pragma once
// The order of fixed tool directions that turns the rotary axes least, and the turns between them.

#include <cstdint>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

/// How far the rotary axes of a tilting head and a turning table go from one direction to the other when both
/// run at the same time: the greater of the change in tilt from `up` and the turn about it (the short way;
/// none where either direction is along `up`, where the table need not turn). Symmetric.
Angle rotary_travel(Vec3 from, Vec3 to, Vec3 up);

/// Most directions that can be ordered, and that exactly.
inline constexpr std::uint32_t kMostDirections = 32, kMostExact = 14;

/// The order with the least sum of rotary_travel from `up` over all directions: exact up to kMostExact [Held,
/// Karp 1962]; of more, one that no turning round of a stretch of it and no moving of one direction makes
/// shorter.
/// Requires: at most kMostDirections, unit.
std::vector<std::uint32_t> order_by_travel(const std::vector<Vec3>& directions, Vec3 up);

/// Directions from `from` to `to`, both included, at most `step` apart, tilt and turn about `up` changing
/// evenly: no direction tilts further from `up` than the two ends.
std::vector<Vec3> turns_between(Vec3 from, Vec3 to, Vec3 up, Angle step);

}  // namespace tiltfeed::pathgen
