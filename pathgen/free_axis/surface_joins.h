#pragma once
// Ways of the ball over the CL surface from the end of one run to the start of the next, in contact all
// along. (J4) in pathgen/free_axis/README.md.

#include <optional>

#include "pathgen/free_axis/move_check.h"
#include "pathgen/free_axis/tool_axis_path.h"

namespace tiltfeed::pathgen {

class SurfaceJoins {
 public:
  /// All must outlive the object. `longest`: how far the ends may be apart, mm; 0: none are joined.
  SurfaceJoins(const Admissibility& admissible, const ToolAxisOptions& options, double longest);

  /// The points after `from`, up to and with `to`. Nothing where the ends are too far apart, the surface
  /// between them is no single sheet, the tool is not clear, or the axis would turn faster than it may.
  /// Properties: those of choose_tool_axes, and contact within the tolerance's share of the slices.
  std::optional<ToolAxisRun> join(const ToolAxisPoint& from, const ToolAxisPoint& to);
  std::uint64_t tested() const { return query_.tested; }

 private:
  std::optional<ClPoint> contact(Point<Part> centre) const;
  bool straight_is_near(const ClPoint& a, const ClPoint& b) const;
  bool follow(const ClPoint& a, const ClPoint& b, int depth, ClStrand& way) const;

  const Admissibility& admissible_;
  const ToolAxisOptions& options_;
  double longest_, gap_;
  DirectionQuery query_;
  MoveCheck moves_;
};

}  // namespace tiltfeed::pathgen
