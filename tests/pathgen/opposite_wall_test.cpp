// What stands in the tool's way near the point, line or circle and beyond it, against the tool's true solid.
#include "pathgen/linking/opposite_wall.h"

#include <gtest/gtest.h>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "tests/judges/tool_proof.h"
#include "tests/shapes/box_mesh.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kFar = 1e9;

CheckedMesh checked_boxes(const std::vector<std::array<Vec3, 2>>& boxes) {
  const Mesh mesh = box_mesh(boxes);
  Stl stl;
  for (const Facet& f : mesh.facets)
    stl.facets.push_back({mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]});
  return *check_mesh(stl);
}

PlanOptions options_along_x(const Cutter& cutter) {
  PlanOptions options;
  options.cutter = cutter;
  options.axis = {AxisMode::kLine, Sense::kInward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};
  options.tolerance = 0.01;
  options.pattern.side_step = 1.0;
  options.links.clearance = 3.0, options.links.approach = 1.0;
  return options;
}

/// The furthest place of the tip on cuts along x, mm, and how deep the tool is in the part anywhere.
struct Findings {
  double nearest = -kFar, gouge = 0.0;
};
Findings planned_on(const CheckedMesh& part, const PlanOptions& options) {
  const auto planned = plan(part, options, nullptr);
  EXPECT_TRUE(planned) << planned.error().message;
  if (!planned) return {};
  const sim::PartDistance surface(part.mesh);
  const ToolProof proof(surface, part.bounds, options.cutter, options.tolerance, {},
                        {options.allowance, options.radial_stock, options.axial_stock});
  Findings found;
  found.gouge = proof.measure(planned->path, 0.05).gouge();
  for (const Move& move : planned->path.moves)
    if (move.kind == MoveKind::kCut) found.nearest = std::max(found.nearest, move.pose.tip.x);
  return found;
}

/// A wall square to the line, which pierces it, and a ledge beside the wall. The tool comes from the line.
/// Its ball passes the wall; what is wider up the tool does not, and touches no edge of the wall on the way.
/// Nor where the wall's lower end is over the tool on the ledge, and under it on the clearance surface.
TEST(OppositeWall, AWallAlongTheAxisIsInTheWayOfWhatIsWiderUpTheTool) {
  Cutter cone{3.0, 100.0, 27.0, CutterType::kTaperBall};
  cone.taper = Angle::from_degrees(7.0);
  Cutter stepped{3.0, 100.0, 27.0};
  stepped.cutting_length = 12.0, stepped.shank_diameter = 10.0;
  const struct {
    Cutter cutter;
    double wall_end;
  } kCases[] = {{cone, -60.0}, {stepped, -60.0}, {stepped, -1.5}};
  for (const auto& [cutter, wall_end] : kCases) {
    const CheckedMesh part =
        checked_boxes({{Vec3{0, -60, wall_end}, Vec3{2, 60, 60}}, {Vec3{-25, -3, -45}, Vec3{-1.8, 3, -30}}});
    PlanOptions options = options_along_x(cutter);
    options.containment.first.high = -1.8;
    const Findings found = planned_on(part, options);
    EXPECT_LE(found.gouge, 0.01) << wall_end;
    // What is further off the wall than the tool is wide is cut.
    EXPECT_NEAR(found.nearest, -cutter.shank_radius(), 0.4) << wall_end;
  }
}

/// A straight row is one move, and its ends are clear of a fin over its middle.
TEST(OppositeWall, AFinOverTheMiddleOfAMoveIsInTheWay) {
  const CheckedMesh part =
      checked_boxes({{Vec3{-25, -3, -14}, Vec3{25, 3, -10}}, {Vec3{-1, -20, 10}, Vec3{1, 20, 20}}});
  const Findings found = planned_on(part, options_along_x({3.0, 100.0, 27.0}));
  EXPECT_LE(found.gouge, 0.01);
  EXPECT_NEAR(found.nearest, 26.5, 0.1);
}

/// The error of rays goes with the part's size: a wall of 2 mm is seen to less than half a micrometre.
TEST(OppositeWall, ASmallPartIsHeldToASmallTolerance) {
  constexpr double kScale = 0.02, kTolerance = 5e-4;
  Cutter stepped{3.0 * kScale, 100.0, 27.0 * kScale};
  stepped.cutting_length = 12.0 * kScale, stepped.shank_diameter = 10.0 * kScale;
  const CheckedMesh part = checked_boxes({{Vec3{0, -60, -60} * kScale, Vec3{2, 60, 60} * kScale},
                                          {Vec3{-25, -3, -45} * kScale, Vec3{-1.8, 3, -30} * kScale}});
  PlanOptions options = options_along_x(stepped);
  options.tolerance = kTolerance, options.pattern.side_step = kScale;
  options.links.clearance = 3.0 * kScale, options.links.approach = kScale;
  options.containment.first.high = -1.8 * kScale;
  const auto planned = plan(part, options, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  const sim::PartDistance surface(part.mesh);
  const ToolProof proof(surface, part.bounds, options.cutter, kTolerance, {}, {});
  EXPECT_LE(proof.measure(planned->path, 0.001).gouge(), 0.6 * kTolerance);
}

/// The tool on one side of a circle's middle comes past a wall on the other side of it. What of its way is
/// nearer to that wall than half of the approach is no rapid; the first pose is where the path begins.
TEST(OppositeWall, RapidsKeepOffItByHalfOfTheApproach) {
  const CheckedMesh part =
      checked_boxes({{Vec3{-4, -4, 3}, Vec3{4, 4, 6}}, {Vec3{-6, 1.8, -9}, Vec3{6, 9, -2.5}}});
  PlanOptions options = options_along_x({3.0, 100.0, 27.0});
  options.axis = {AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 10.0};
  options.links.clearance = 3.0, options.links.approach = 2.0, options.links.join_distance = 0.0;
  const auto planned = plan(part, options, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid tool(options.cutter);
  double nearest = kFar;
  const auto& moves = planned->path.moves;
  std::size_t rapids = 0;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    // Away from a cut the tool goes by the way on which it is.
    if (moves[i].kind != MoveKind::kRapid || moves[i - 1].kind == MoveKind::kCut) continue;
    ++rapids;
    for (int k = 1; k <= 20; ++k) {
      const Pose pose{lerp(moves[i - 1].pose.tip, moves[i].pose.tip, k / 20.0),
                      slerp(moves[i - 1].pose.axis, moves[i].pose.axis, k / 20.0)};
      nearest = std::min(nearest, tool.clearance(surface, pose, sim::ToolPart::kCutter).value);
    }
  }
  EXPECT_GT(rapids, 0u);
  EXPECT_GE(nearest, 0.5 * options.links.approach - options.tolerance);
}

/// Axial stock lowers the ring: at the line's height it is beside the rail, and the tool's reference is not.
TEST(ColumnEnds, AreCoveredByWhatIsBesideTheRing) {
  const CheckedMesh part =
      checked_boxes({{Vec3{-25, -3, -20}, Vec3{25, 3, -15}}, {Vec3{-30, 2.46, -0.5}, Vec3{30, 8, -0.45}}});
  PlanOptions options = options_along_x({3.0, 100.0, 14.0});
  options.radial_stock = 1.0, options.axial_stock = 0.5;
  options.links.clearance = 0.02, options.links.approach = 0.01;
  EXPECT_LE(planned_on(part, options).gouge, 0.01);
}

}  // namespace
}  // namespace tiltfeed
