#pragma once
// The moves of a pass: none turns or is longer than it may, and each is clear all along. (O5) in
// pathgen/free_axis/README.md.

#include <array>
#include <vector>

#include "pathgen/free_axis/admissible.h"
#include "pathgen/free_axis/tool_axis_run.h"

namespace tiltfeed::pathgen {

/// A point of a run and where it is on the pass, mm.
struct PlacedPoint {
  double way = 0.0;
  ToolAxisPoint at;
};
using PlacedRun = std::vector<PlacedPoint>;

/// With points between, evenly, where a move would turn or be longer than allowed.
PlacedRun divided(const PlacedRun& run, const ToolAxisOptions& options);

class MoveCheck {
 public:
  /// All must outlive the object.
  MoveCheck(const Admissibility& admissible, const ToolAxisOptions& options, DirectionQuery& query);

  /// Is the tool clear, and within the tilt limit, all along the move? Moves that were clear in the last
  /// round or in this one are known. Requires: in each round moves come in rising order.
  bool clear(const PlacedPoint& a, const PlacedPoint& b);
  void next_round();
  /// The same of any move.
  bool clear(const ToolAxisPoint& a, const ToolAxisPoint& b);

 private:
  bool known_clear(const PlacedPoint& a, const PlacedPoint& b) const;
  bool clear_by_bound(const ToolAxisPoint& a, const ToolAxisPoint& b);
  double room(double lean) const;

  struct Cleared {
    double from;
    std::array<Vec3, 2> axes;
    double to;
  };
  const Admissibility& admissible_;
  const ToolAxisOptions& options_;
  DirectionQuery& query_;
  std::vector<Cleared> before_, now_;
};

}  // namespace tiltfeed::pathgen
