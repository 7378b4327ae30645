#pragma once
// Which pieces of a tool path come near the pole, and which way its axis goes.

#include <cstddef>
#include <vector>

#include "kinematics/basics/tool_path.h"

namespace tiltfeed {

/// Moves first + 1 to last, all cutting and near the pole, between the points first and last.
struct SingularityPiece {
  std::size_t first = 0, last = 0;
};

/// A move that turns the axis by less (rad) says nothing of its way.
inline constexpr double kNoTurn = 1e-7;

/// Where the axis goes at the start of the great circle from a to b, unit, square to a; zero where it stands.
Vec3 way_of(Vec3 a, Vec3 b);

/// The longest pieces whose every move comes within `reach` (rad) of the pole (unit); a new one begins where
/// the axis turns off sharply, by more than 45 degrees.
std::vector<SingularityPiece> pieces_near_singularity(const ToolPath& path, Vec3 pole, double reach);

}  // namespace tiltfeed
