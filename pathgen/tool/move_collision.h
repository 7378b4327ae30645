#pragma once
// The tool against the part all along a straight move: the planner's one check of it, and the same asked
// about single moves from outside. (O5) in pathgen/free_axis/README.md.

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

#include "kinematics/basics/tool_path.h"
#include "kinematics/basics/units.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

class FacetBvh;
class SweptTool;

/// The cosine of the largest angle to `up` on the great circle from a to b. Requires: all unit.
double least_cosine(Vec3 a, Vec3 b, Vec3 up);

/// How far the tool axis may tilt.
class TiltLimit {
 public:
  /// `up`: the table's axis in part directions, unit.
  TiltLimit(Vec3 up, Angle limit)
      : up_(up),
        cosine_(limit.radians() < kPi ? std::cos(limit.radians())
                                      : -std::numeric_limits<double>::infinity()) {}
  bool allows(Vec3 axis) const { return dot(up_, axis) >= cosine_; }
  /// All along the great circle from a to b, which beyond 90 degrees leans over further than both.
  bool allows(Vec3 a, Vec3 b) const { return cosine_ <= -1.0 || least_cosine(a, b, up_) >= cosine_; }

 private:
  Vec3 up_;
  double cosine_;
};

/// Where a tool stands.
struct ToolStand {
  Point<Part> centre;  ///< of its CL reference
  Vec3 axis;           ///< unit
};

/// Are cutter, shank and holder clear of the part all along the move (tip straight, axis on the great
/// circle), can they be drawn back along the axis from all of it, and does the axis keep within the limit?
/// The ball itself is not asked about: it touches where it works. Below kBoundedFrom radii of the ball over
/// the reference poses are asked between which no point of the tool moves further than what a ball leaves of
/// a corner within its share of `tolerance` (mm); what is higher by one bound, if that tells. `hint`: as
/// SweptTool::stop; `tested`: grows by what was held against the part; `back`: how far the tool is drawn
/// back, mm.
bool clear_along(const SweptTool& tool, const TiltLimit& tilt, const ToolStand& from, const ToolStand& to,
                 double reference_height, double tolerance, std::uint32_t& hint, std::uint64_t& tested,
                 double back = std::numeric_limits<double>::infinity());

/// clear_along() for those who have no tree of the part.
class MoveCollision {
 public:
  /// Requires: a ball or taper-ball cutter. The mesh and the options need not outlive it.
  MoveCollision(const Mesh& mesh, const PlanOptions& options);
  ~MoveCollision();

  /// With the clearances and the tilt limit of the options. Safe to call from several threads.
  bool clear(const Pose& from, const Pose& to) const;

 private:
  std::unique_ptr<const FacetBvh> tree_;
  std::unique_ptr<const SweptTool> tool_;
  TiltLimit tilt_;
  double reference_height_, tolerance_;
};

}  // namespace tiltfeed::pathgen
