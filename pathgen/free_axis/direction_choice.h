#pragma once
// The cheapest sequence of tool axes along a pass: a shortest path through the candidates of its stations.

#include <cstdint>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "pathgen/axis/direction_grid.h"

namespace tiltfeed::pathgen {

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

/// (O3) The sequence of least cost: the candidates' own costs and those of the turns.
class CheapestSequence {
 public:
  /// Requires: no list is empty, each is in the order of axis.z; `ways` (mm, above 0) are those from each
  /// station to the next. The lists must outlive the object, and so must `near`, which may be null: it makes
  /// the search faster.
  CheapestSequence(std::vector<const AxisCandidates*> stations, std::vector<double> ways,
                   const TurnPrices& prices, const DirectionNeighbours* near);

  /// For each station the index of its candidate. Equals are settled by keeping the direction, else by the
  /// nearer one. The lists of stations before `changed` must be what they were when it was asked last.
  std::vector<std::uint32_t> find(std::size_t changed = 0);

 private:
  struct Turns;
  void reach(std::size_t station);
  bool reach_by_neighbours(std::size_t station, const Turns& turns);
  void reach_by_height(std::size_t station, const Turns& turns);

  std::vector<const AxisCandidates*> stations_;
  std::vector<double> ways_;
  TurnPrices prices_;
  const DirectionNeighbours* near_;
  std::vector<double> cost_at_;  ///< of a list: the costs of the grid's directions,
  std::vector<std::uint32_t> place_,
      others_;                                    ///< their places, and those of the rest
  std::vector<std::vector<double>> cost_;         ///< of the cheapest sequence up to each candidate
  std::vector<std::vector<std::uint32_t>> from_;  ///< and its candidate one station before
};

}  // namespace tiltfeed::pathgen
