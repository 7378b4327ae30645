#pragma once
// The whole tool against the blank, from the safe side.

#include <limits>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

/// Cutter, shank and holder of a job against its blank, by balls as wide as each piece along its axis.
class ToolInBlank {
 public:
  /// Requires: options.blank. `options` must outlive it. The tool keeps off by half of the approach, as
  /// rapids do.
  explicit ToolInBlank(const PlanOptions& options);

  /// Would it come too near, its CL reference there and its unit axis so? Never false where it does; true up
  /// to half of a piece's radius too early, beside corners of the blank.
  /// `above`: what is no higher over the reference is not asked, mm.
  bool stands_in(Point<Part> reference, Vec3 axis,
                 double above = -std::numeric_limits<double>::infinity()) const;
  /// The same on a straight move between two poses, which turns evenly.
  bool moves_in(const Pose& from, const Pose& to) const;
  /// Places of such a move, so that all between is seen.
  double steps(const Pose& from, const Pose& to) const;
  /// Heights over the reference along `axis`: from `high` down to which the tool comes clear, at least `low`;
  /// `high` where it is not clear even there.
  double clear_down_to(Point<Part> reference, Vec3 axis, double high, double low) const;

 private:
  const PlanOptions& options_;
  std::vector<ToolPiece> pieces_;
  double margin_, reference_height_, step_;
};

}  // namespace tiltfeed::pathgen
