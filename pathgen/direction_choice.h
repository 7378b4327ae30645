#pragma once
// The cheapest sequence of tool axes along a pass: a shortest path through the candidates of its stations.

#include <cstdint>
#include <vector>

#include "kinematics/geometry.h"

namespace tiltfeed {

inline constexpr std::uint32_t kNoDirection = 0xffffffff;

/// One candidate direction of a station, and what choosing it costs.
struct AxisCandidate {
  Vec3 axis;  ///< unit
  double cost = 0.0;
  std::uint32_t direction = kNoDirection;  ///< of the grid
  bool clear = false;                      ///< it is known to be admissible
};

struct TurnPrices {
  double turn = 0.0;      ///< times angle^2 / way between neighbours
  double max_turn = 0.0;  ///< rad/mm, and
  double spare = 0.0;  ///< rad: where the angle is over max_turn times the way and this the sequence breaks
  double jump = 0.0;   ///< for each break
};

using AxisCandidates = std::vector<AxisCandidate>;

/// (O3) For each station the index of its candidate in the sequence of least cost: the candidates' own costs
/// and those of the turns. Equals are settled by the lower index. Requires: no list is empty, each is in the
/// order of axis.z; `ways` (mm, above 0) are those from each station to the next.
std::vector<std::uint32_t> cheapest_sequence(const std::vector<const AxisCandidates*>& stations,
                                             const std::vector<double>& ways, const TurnPrices& prices);

}  // namespace tiltfeed
