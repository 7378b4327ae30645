// What passes leave between them: against every move of the path by brute force, and in closed form.

#include "pathgen/plan/between_passes.h"

#include <gtest/gtest.h>

#include <random>

#include "pathgen/axis/direction_grid.h"
#include "pathgen/options/side_step.h"
#include "pathgen/plan/rest_material.h"
#include "pathgen/plan/rest_of_cells.h"
#include "sim/solid/tool_solid.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// Of a point, as a facet too small to see.
double distance_to_point(const sim::ToolSolid& tool, const Pose& pose, Point<Part> p) {
  Mesh mesh;
  constexpr double kTiny = 1e-7;
  mesh.vertices = {p, p + Vec3{kTiny, 0, 0}, p + Vec3{0, kTiny, 0}};
  mesh.facets = {{0, 1, 2}};
  mesh.source = {0};
  return tool.clearance(sim::PartDistance(mesh), pose, sim::ToolPart::kCutter).value;
}

Cutter cutter_of(CutterType type) {
  Cutter cutter{4.0, 100.0, 40.0};
  cutter.type = type;
  cutter.corner_radius = 0.5;
  cutter.taper = Angle::from_degrees(10.0);
  return cutter;
}

/// Rows over the plane z = 0, a millimetre apart, touching it with an axis that leans this way and that.
std::vector<Move> rows(const Cutter& cutter, std::mt19937& random) {
  std::uniform_real_distribution<double> lean(-0.3, 0.3), turn(-0.01, 0.01);
  const double corner = cutter.nose_radius();
  std::vector<Move> moves;
  for (int row = 0; row < 6; ++row) {
    const double x = lean(random), y = lean(random);
    for (int i = 0; i <= 5; ++i) {
      const Vec3 axis = normalized(Vec3{x + turn(random), y + turn(random), 1.0});
      moves.push_back({{Point<Part>{1.5 * i, 1.0 * row, corner} - axis * corner, axis},
                       i == 0 ? MoveKind::kRapid : MoveKind::kCut});
    }
  }
  return moves;
}

TEST(BetweenPasses, LeftIsTheLeastOfAllMoves) {
  std::mt19937 random(3);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (const CutterType type :
       {CutterType::kBall, CutterType::kBullNose, CutterType::kFlat, CutterType::kTaperBall}) {
    SCOPED_TRACE(static_cast<int>(type));
    PlanOptions o;
    o.cutter = cutter_of(type);
    const double corner = o.cutter.nose_radius();
    const std::vector<Move> moves = rows(o.cutter, random);
    const ToolPiece piece = tool_pieces(o).front();
    const CuttingMoves cutting(moves, piece, corner, 1.0);
    const sim::ToolSolid tool(o.cutter);
    std::size_t told = 0;
    for (int k = 0; k < 40; ++k) {
      const Point<Part> place{between(-1, 8.5), between(-1, 6), k % 4 == 0 ? -0.2 : 0.0};
      double least = 1e9;
      for (std::size_t i = 1; i < moves.size(); ++i)
        for (int s = 0; moves[i].kind == MoveKind::kCut && s <= 60; ++s) {
          const Pose &a = moves[i - 1].pose, &b = moves[i].pose;
          const double share = s / 60.0;
          const Pose pose{lerp(a.tip, b.tip, share), normalized(a.axis * (1 - share) + b.axis * share)};
          least = std::min(least, distance_to_point(tool, pose, place));
        }
      const Vec3 aside = normalized(Vec3{between(-1, 1), between(-1, 1), 0});
      const Point<Part> touching = place + Vec3{0, 0, corner} + aside * piece.flat;
      const double left = cutting.left(place, touching, -1e9);
      if (least < cutting.farthest() - 1e-3) {
        ++told;
        EXPECT_NEAR(std::max(left, 0.0), std::max(least, 0.0), 2e-3) << place.x << " " << place.y;
        EXPECT_LE(cutting.left(place, touching, 0.5), std::max(0.5, left + 2e-3));
        EXPECT_GE(cutting.left(place, touching, 0.5), left - 1e-9);
      }
    }
    EXPECT_GT(told, 20u);
    EXPECT_EQ(cutting.left({0, 60, 0}, {0, 60, corner}, 0.0), cutting.farthest()) << "never cut";
  }
}

/// A slope that falls by `degrees` across the rows, cut by a ball of 2 mm.
struct Slope {
  double degrees, step;
  StepMeasure measure;

  CheckedMesh part() const {
    const double fall = std::tan(Angle::from_degrees(degrees).radians());
    return sheet(kUpright, {-10, 10, -5, 5, 40, 40}, [=](double, double y) { return -fall * y; });
  }
  PlanOptions options() const {
    PlanOptions o = options_with(kUpright);
    o.pattern.side_step = step;
    o.pattern.measure = measure;
    o.pattern.scallop = ridge(step);
    o.find_rest_material = true;
    return o;
  }
  /// Height of what is left between two rows that are so far apart on the surface.
  static double ridge(double apart) { return 2.0 - std::sqrt(4.0 - apart * apart / 4.0); }
};

TEST(BetweenPasses, FlatStepsOnASteepSlopeAreTold) {
  const Slope slope{70.0, 0.5, StepMeasure::kFlat};
  const auto planned = plan(slope.part(), slope.options(), nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  const BetweenPasses& between = planned->report.uncut->between;
  const double tolerance = slope.options().tolerance,
               apart = slope.step / std::cos(Angle::from_degrees(slope.degrees).radians());
  EXPECT_NEAR(between.limit, 4.0 * Slope::ridge(slope.step) + tolerance, 1e-12);
  EXPECT_NEAR(between.most, Slope::ridge(apart), 0.15 * Slope::ridge(apart));
  EXPECT_LE(between.most, Slope::ridge(apart) + tolerance);
  EXPECT_GT(between.area, 0.1 * planned->report.uncut->facing_area);
  EXPECT_NE(between.facet, kNoFacet);
  EXPECT_NEAR(between.place.z, -std::tan(Angle::from_degrees(70.0).radians()) * between.place.y, 1e-6);
  EXPECT_FALSE(between.never);
  ASSERT_FALSE(planned->report.warnings.empty());
  EXPECT_NE(planned->report.warnings.back().find("between passes more is left than the "), std::string::npos);
}

TEST(BetweenPasses, StepsOnThePartLeaveWhatIsAsked) {
  for (const StepMeasure measure : {StepMeasure::kSurface, StepMeasure::kScallop})
    for (const double degrees : {0.0, 40.0, 70.0}) {
      SCOPED_TRACE(degrees);
      const Slope slope{degrees, 0.5, measure};
      const auto planned = plan(slope.part(), slope.options(), nullptr);
      ASSERT_TRUE(planned) << planned.error().message;
      const BetweenPasses& between = planned->report.uncut->between;
      EXPECT_EQ(between.area, 0.0) << between.most << " at " << between.place.x << " " << between.place.y;
      EXPECT_LE(between.most, between.limit);
      for (const std::string& warning : planned->report.warnings)
        EXPECT_EQ(warning.find("between passes"), std::string::npos) << warning;
    }
}

TEST(BetweenPasses, AMissingRowIsFound) {
  const Slope slope{20.0, 0.5, StepMeasure::kScallop};
  const CheckedMesh part = slope.part();
  const PlanOptions o = slope.options();
  const auto planned = plan(part, o, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  std::vector<std::string> warnings;
  const auto field = make_field(part, o, warnings);
  ASSERT_TRUE(field);
  const EnvelopeOptions envelope{o.tolerance / 4.0};
  std::vector<Move> moves = planned->path.moves;
  for (Move& move : moves)
    if (std::abs((move.pose.tip + move.pose.axis * 2.0).y) < 0.3) move.kind = MoveKind::kRapid;
  const BetweenPasses between = find_rest_material(**field, o, envelope, moves).between;
  EXPECT_GT(between.most, 2.0 * Slope::ridge(0.5));
  EXPECT_NEAR(between.place.y, 0.0, 1.5);
  EXPECT_GT(between.area, 1.0);
  EXPECT_EQ(find_rest_material(**field, o, envelope, planned->path.moves).between.area, 0.0);
  const RestReport kept_off =
      find_rest_material(**field, o, envelope, moves, {}, [](const EnvelopePoint&) { return true; });
  EXPECT_EQ(kept_off.between.area, 0.0) << "it is not between passes but out of reach";
  EXPECT_LE(kept_off.between.most, kept_off.between.limit);
  EXPECT_GT(kept_off.area, 1.0);
  EXPECT_EQ(kept_off.facets.front().why, RestReason::kShank);
  const RestReport none = find_rest_material(**field, o, envelope, {});
  EXPECT_TRUE(none.between.never);
}

/// The same slope with an axis of its own at each place, or one chosen for it; not its sides.
PlanOptions options_of(const Slope& slope, AxisMode mode) {
  PlanOptions o = slope.options();
  o.axis.mode = mode;
  o.containment.first = {-8.0, 8.0};
  o.containment.second = {-3.5, 3.5};
  o.tilt_max = Angle::from_degrees(80.0);
  o.free.plane_normals = {{0, 1, 0}};
  return o;
}

TEST(RestOfCells, RowsOfAFreeOrIndexedAxisLeaveTheirRidge) {
  for (const AxisMode mode : {AxisMode::kFree, AxisMode::kIndexed})
    for (const double degrees : {0.0, 72.0}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(mode)) + ", " + std::to_string(degrees));
      const Slope slope{degrees, 0.5, StepMeasure::kFlat};  // rows run along edges of the mesh
      const auto planned = plan(slope.part(), options_of(slope, mode), nullptr);
      ASSERT_TRUE(planned) << planned.error().message;
      ASSERT_TRUE(planned->report.between);
      const BetweenPasses& between = *planned->report.between;
      const double tolerance = slope.options().tolerance;
      // Planes of slices stand upright, so that they are further apart on a slope; a chosen axis faces it.
      const double fall = mode == AxisMode::kFree ? Angle::from_degrees(degrees).radians() : 0.0,
                   apart = slope.step / std::cos(fall), ridge = Slope::ridge(apart);
      EXPECT_NEAR(between.limit, 4.0 * Slope::ridge(slope.step) + tolerance, 1e-12);
      EXPECT_EQ(between.area > 0.0, ridge > between.limit);
      EXPECT_GE(between.most, 0.8 * ridge);
      // Beyond the last row lies up to a step.
      EXPECT_LE(between.most, std::max(Slope::ridge(2.0 * apart) + tolerance, between.limit));
      const bool told = !planned->report.warnings.empty() &&
                        planned->report.warnings.back().find("between passes more") != std::string::npos;
      EXPECT_EQ(told, ridge > between.limit);
    }
}

TEST(RestOfCells, AMissingRowIsFoundWhereTheToolReaches) {
  const Slope slope{20.0, 0.47, StepMeasure::kFlat};
  const CheckedMesh part = slope.part();
  const PlanOptions o = options_of(slope, AxisMode::kFree);
  const auto planned = plan(part, o, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  std::vector<Move> moves = planned->path.moves;
  for (Move& move : moves)
    if (std::abs((move.pose.tip + move.pose.axis * 2.0).y) < 1.2) move.kind = MoveKind::kRapid;
  const FacetBvh tree(part.mesh);
  const SweptTool tool(tree, o, o.tolerance);
  const std::vector<Vec3> up{{0, 0, 1}}, aside{{0, 0.985, -0.17}};
  const BetweenPasses between = find_rest_of_cells(part, o, tool, up, moves);
  EXPECT_GT(between.most, 4.0 * Slope::ridge(0.47));
  EXPECT_NEAR(between.place.y, 0.0, 1.5);
  EXPECT_GT(between.area, 1.0);
  EXPECT_EQ(find_rest_of_cells(part, o, tool, aside, moves).area, 0.0) << "the tool cannot come from there";
  PlanOptions elsewhere = o;
  elsewhere.containment.second.low = 4.0;
  EXPECT_EQ(find_rest_of_cells(part, elsewhere, tool, up, moves).area, 0.0) << "not asked for";
  EXPECT_EQ(find_rest_of_cells(part, o, tool, up, planned->path.moves).area, 0.0);
  EXPECT_TRUE(find_rest_of_cells(part, o, tool, up, {}).never);
}

}  // namespace
}  // namespace tiltfeed
