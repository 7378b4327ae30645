#pragma once
// The planner's check of the tool against the part, asked about single moves from outside.

#include <memory>

#include "kinematics/tool_path.h"
#include "pathgen/mesh.h"
#include "pathgen/plan_options.h"

namespace tiltfeed {

class FacetTree;
class SweptTool;

class MoveClearance {
 public:
  /// Requires: a ball or taper-ball cutter. The mesh and the options need not outlive it.
  MoveClearance(const Mesh& mesh, const PlanOptions& options);
  ~MoveClearance();

  /// Are cutter, shank and holder, with their clearances, clear of the part all along the move (tip straight,
  /// axis on the great circle), can they be drawn back along the axis from all of it, and does the axis keep
  /// within PlanOptions::tilt_max? The ball itself is not asked about: it touches where it works. (A1)..(A3)
  /// in pathgen/README.md. Safe to call from several threads.
  bool clear(const Pose& from, const Pose& to) const;

 private:
  std::unique_ptr<const FacetTree> tree_;
  std::unique_ptr<const SweptTool> tool_;
  Vec3 up_;
  double reference_height_, tilt_cosine_, lever_, step_;
};

}  // namespace tiltfeed
