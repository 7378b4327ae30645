#pragma once
// Holds a machined surface against what its passes must leave, with any cutter: at random places of the part
// that the tool can touch, the true solid stands where a pass must be, let down from outside. More left than
// that leaves is a place that was not cut. Where a pass must be:
// - flat raster along x' or y': either of the two planned passes beside the place; the better one counts;
// - else somewhere within a reach of the place in flat space; the worst of all places there counts. Reach:
//   contour and spiral 0.65 side steps; rows at an angle 0.5; measured on the part 1, as the first rows are
//   two apart; z_level and split 2 of the larger of side step and step down, and z_level only where the
//   heights to two opposite sides differ by more than the step down, so that a level lies between.
// Rows by their ridges may leave what rows at an angle may, or the ridge that their plan says it allows, and
// half the tolerance. Of a rough no bound is known.

#include <optional>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/plan/plan.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed::attack {
using namespace pathgen;

class CoverJudge {
 public:
  /// A bound is known.
  static bool can_judge(const PlanOptions& options);

  /// All must outlive the judge. `planned`: where the passes lie, and the ridge that it allows; `executed`:
  /// what the machine makes of it.
  CoverJudge(const PlanOptions& options, const CheckedMesh& part, const Plan& planned,
             const ToolPath& executed, const sim::Growth& growth);

  struct Found {
    std::size_t points = 0;           ///< that the tool reaches, with a pass that must be near
    double excess = -sim::kInfinity;  ///< most left over what must be, mm
    Point<Part> at;
    Pose seat;  ///< of a tool that touches there
  };
  Found look(int surface_points) const;

 private:
  std::vector<double> pass_places(const ToolPath& path) const;
  double across(Point<Flat> f) const { return options_.pattern.along == Along::kX ? f.y : f.x; }
  Point<Part> reference(const Pose& pose) const { return pose.tip + pose.axis * nose_; }
  Pose standing(Point<Part> reference) const;
  Pose seat(Point<Part> p, Vec3 normal) const;
  double way_out(Point<Part> p) const;
  bool is_wanted(const Pose& pose) const;
  bool is_beyond(const AxisLine& column, const Pose& pose) const;
  bool is_free(const Pose& pose) const;
  double leaves(Point<Part> p, const Pose& pose) const;
  double must_leave(Point<Part> p, const Pose& seat) const;
  double must_leave_within(Point<Part> p, Point<Flat> flat) const;
  double mean_rho() const;
  bool in_boundary(double first, double second) const;
  double left_by_pass(Point<Part> p, Point<Flat> flat, double place) const;
  double left_by_move(Point<Part> p, const Pose& a, const Pose& b, double way) const;
  double left_by_path(Point<Part> p) const;
  void look_at(Point<Part> p, Vec3 normal, Found& found) const;

  const PlanOptions& options_;
  const CheckedMesh& checked_;
  const ToolPath& executed_;
  sim::Growth growth_;
  sim::PartDistance part_;
  sim::ToolSolid tool_, drawn_;
  Deformation map_;
  std::optional<sim::PartDistance> fixtures_;  ///< and faces that are not to be touched
  double nose_, flat_radius_;
  Deformation laid_;  ///< flat space as passes are laid out in it; map_ has angles
  double reach_;      ///< mm of laid_; 0: passes are straight, and known one by one
  double ridge_;      ///< mm; so much rows by their ridges may leave anywhere
  std::vector<double> places_;
};

}  // namespace tiltfeed::attack
