// A predefined axis that gives way: leans against closed forms, brute force over directions, the true solids
// of the tool, and the path without guards.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "pathgen/lean/lean_stations.h"
#include "pathgen/lean/leaned_passes.h"
#include "pathgen/tool/blank_solid.h"
#include "sim/solid/tool_solid.h"
#include "tests/judges/reach.h"
#include "tests/judges/tool_proof.h"
#include "tests/samples.h"
#include "tests/shapes/box_mesh.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kDegree = kPi / 180.0;

/// 60 mm long in x, over the places (y, z); two with one y are a wall. On the plane z = -10.
CheckedMesh drawn_along_x(const std::vector<std::array<double, 2>>& profile) {
  constexpr std::size_t kColumns = 4;
  Shell shell;
  shell.at = [&](std::size_t i, std::size_t j, bool top) {
    return Point<Part>{60.0 * (1.0 - static_cast<double>(j) / kColumns), profile[i][0],
                       top ? profile[i][1] : -10.0};
  };
  const std::size_t rows = profile.size() - 1;
  shell.faces(rows, kColumns);
  for (std::size_t j = 0; j < kColumns; ++j) shell.end(0, j + 1, j), shell.end(rows, j, j + 1);
  for (std::size_t i = 0; i < rows; ++i) shell.side(i, i + 1, 0), shell.side(i + 1, i, kColumns);
  return shell.checked();
}

/// A tool with a holder 16 mm wide and 30 long, 18 mm over the ball's centre; at most `limit` degrees of
/// lean.
PlanOptions leaning_options(const AxisFrame& axis, double limit) {
  PlanOptions o = options_with(axis);
  o.cutter = {4.0, 100.0, 20.0};
  o.cutter.cutting_length = 8.0, o.cutter.shank_diameter = 4.0;
  o.cutter.holder = {{16.0, 16.0, 30.0}};
  o.holder = {0.5, Reaction::kTilt}, o.shank = {0.0, Reaction::kTilt};
  o.lean = {Angle::from_degrees(limit), Angle::from_degrees(10.0)};
  o.links.join_distance = 3.0;
  return o;
}

PlanOptions without_guards(PlanOptions o) {
  o.cutter.holder.clear(), o.holder = {}, o.shank = {}, o.lean = {};
  return o;
}
PlanOptions trimming(PlanOptions o) {
  o.holder.reaction = o.shank.reaction = Reaction::kTrim;
  return o;
}

Plan planned(const CheckedMesh& part, const PlanOptions& options) {
  auto made = plan(part, options, nullptr);
  EXPECT_TRUE(made) << made.error().message;
  return made ? std::move(*made) : Plan{};
}

Point<Part> centre_of(const Pose& pose, const PlanOptions& o) {
  return pose.tip + pose.axis * reference_height(o.cutter);
}

/// Of the axis of the mode at the ball's centre.
double lean_of(const Pose& pose, const PlanOptions& o) {
  return angle_between(pose.axis, Deformation(o.axis, 1.0).axis_at(centre_of(pose, o)));
}

/// No lean is over the limit, and none changes faster than it may, on the cuts of a path.
void expect_within_limits(const ToolPath& path, const PlanOptions& o) {
  const Deformation map(o.axis, 1.0);
  for (std::size_t i = 1; i < path.moves.size(); ++i) {
    if (path.moves[i].kind != MoveKind::kCut) continue;
    const Pose &a = path.moves[i - 1].pose, &b = path.moves[i].pose;
    ASSERT_LE(lean_of(b, o), o.lean.limit.radians() + 1e-9);
    const double way = distance(centre_of(a, o), centre_of(b, o)),
                 field = angle_between(map.axis_at(centre_of(a, o)), map.axis_at(centre_of(b, o)));
    ASSERT_LE(angle_between(a.axis, b.axis), field + 1.01 * o.lean.max_turn.radians() * way + 1e-6)
        << pasteable(a) << " " << pasteable(b);
  }
}

/// The true solids of cutter, shank and holder keep their clearances on cuts and links.
void expect_clear(const CheckedMesh& part, const ToolPath& path, const PlanOptions& o) {
  const sim::PartDistance distances(part.mesh);
  const ToolProof proof(distances, part.bounds, o.cutter, o.tolerance,
                        {0.0, o.shank.clearance, o.holder.clearance}, {o.allowance});
  const ToolFindings found = proof.measure(path, 0.25);
  EXPECT_GT(found.cut_poses, 500u);
  EXPECT_EQ(found.buried, 0u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LE(found.cut[i].value, o.tolerance) << "part " << i << " at " << pasteable(found.cut[i].at);
    EXPECT_LE(found.link[i].value, o.tolerance) << "part " << i << " at " << pasteable(found.link[i].at);
  }
}

/// A floor 60 mm long beside a wall 40 mm high on y = 0.
CheckedMesh floor_beside_wall() { return drawn_along_x({{-10, 40}, {0, 40}, {0, 0}, {40, 0}}); }

/// What a holder of radius r (with its clearance), h over the ball's centre, needs beside a wall d from the
/// centre: its lower rim leans away until r cos q - h sin q = d.
double needed_lean(double r, double h, double d) {
  const double far = std::hypot(r, h);
  return d >= r ? 0.0 : std::acos(d / far) - std::atan2(h, r);
}

TEST(Lean, BesideAWallIsWhatTheFormulaSays) {
  const CheckedMesh part = floor_beside_wall();
  PlanOptions o = leaning_options(kUpright, 50.0);
  o.containment.second = {0.0, 20.0};
  const Plan made = planned(part, o);
  std::size_t leaning = 0, upright = 0;
  for (const CutRun& run : dense(runs_of(made.path), 1.0))
    for (const Pose& pose : run) {
      const Point<Part> c = centre_of(pose, o);
      // Away from the wall's ends, where another way may be shorter.
      if (c.x < 20.0 || c.x > 40.0 || c.y < 2.0 || c.z > 3.0) continue;
      const double need = needed_lean(8.5, 17.5, c.y), lean = lean_of(pose, o);
      EXPECT_GE(lean, need - 0.05 * kDegree) << pasteable(pose);
      EXPECT_LE(lean, need + 0.4 * kDegree) << pasteable(pose);
      ++(need > 0.0 ? leaning : upright);
    }
  EXPECT_GT(leaning, 50u);
  EXPECT_GT(upright, 50u);
  expect_within_limits(made.path, o);
  expect_clear(part, made.path, o);
  EXPECT_NEAR(made.report.lean->largest.radians(), needed_lean(8.5, 17.5, 2.0), 3.0 * kDegree);
}

/// Before the first operation the blank stands: no rapid of a tool that leans ends in it.
TEST(Lean, KeepsRapidsOutOfTheBlank) {
  const CheckedMesh part = floor_beside_wall();
  PlanOptions o = leaning_options(kUpright, 50.0);
  o.containment.first = {15.0, 45.0}, o.containment.second = {0.0, 6.0};
  o.links.join_distance = 0.0;
  Box box = part.bounds;
  box.max.z += 40.0;
  o.blank = std::make_shared<const BlankSolid>(BlankSolid::box(box));
  o.from_blank = true;
  const Plan made = planned(part, o);
  std::size_t leaning = 0, plunges = 0;
  for (const Move& move : made.path.moves) {
    const bool leans = lean_of(move.pose, o) > kDegree;
    if (move.kind == MoveKind::kPlunge) plunges += leans && o.blank->holds(move.pose.tip, 0.0) ? 1 : 0;
    if (move.kind != MoveKind::kRapid) continue;
    leaning += leans ? 1 : 0;
    EXPECT_FALSE(o.blank->holds(move.pose.tip, 0.0)) << pasteable(move.pose);
  }
  EXPECT_GT(leaning, 1u);
  EXPECT_GT(plunges, 1u);
}

/// Between two walls there is no lean: what is further from both than the holder is wide needs none.
TEST(Lean, OfASlotNarrowerThanTheHolderIsNone) {
  const CheckedMesh part = drawn_along_x({{-10, 40}, {0, 40}, {0, 0}, {14, 0}, {14, 40}, {24, 40}});
  PlanOptions o = leaning_options(kUpright, 50.0);
  o.containment.first = {15.0, 45.0}, o.containment.second = {2.0, 12.0};
  const auto made = plan(part, o, nullptr);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Code::kUnreachable);
  EXPECT_NE(made.error().message.find("axis.lean_limit_deg"), std::string::npos) << made.error().message;
}

/// The ball goes where it goes without holder, so that what it cuts is the same.
TEST(Lean, LeavesTheSurfaceThatIsCutAsItIs) {
  const CheckedMesh part = floor_beside_wall();
  PlanOptions o = leaning_options(kUpright, 50.0);
  o.containment.second = {0.0, 20.0}, o.containment.first = {-1.0, 61.0};
  const Plan made = planned(part, o), plain = planned(part, without_guards(o));
  const auto centres = [&](const ToolPath& path) {
    std::vector<CutRun> runs = runs_of(path);
    for (CutRun& run : runs)
      for (Pose& pose : run) pose.tip = centre_of(pose, o);
    return runs;
  };
  const std::vector<CutRun> leaned = centres(made.path), upright = centres(plain.path);
  EXPECT_EQ(made.report.lean->left, 0.0);
  EXPECT_GT(made.report.lean->length, 200.0);
  for (const auto& [of, in] : {std::pair{&leaned, &upright}, std::pair{&upright, &leaned}})
    for (const CutRun& run : dense(*of, 0.5))
      for (const Pose& pose : run) ASSERT_LE(from_runs(pose.tip, *in), o.tolerance) << pasteable(pose);
}

/// A bowl 34 mm deep, hardly wider than the holder.
CheckedMesh bowl() {
  return sheet(kUpright, {-20, 20, -20, 20, 80, 80}, [](double u, double v) {
    const double r2 = (u * u + v * v) / (9.0 * 9.0);
    return -34.0 * std::exp(-r2 * r2);
  });
}

/// Does the tool stand clear with that axis, its ball where it is?
bool stands_clear(const sim::ToolSolid& tool, const sim::PartDistance& surface, Point<Part> centre, Vec3 axis,
                  const PlanOptions& o) {
  const Pose pose{centre - axis * reference_height(o.cutter), axis};
  const double keep[] = {-o.tolerance, o.shank.clearance, o.holder.clearance};
  for (std::size_t i = 0; i < 3; ++i)
    if (tool.clearance(surface, pose, sim::kToolParts[i], keep[i]).facet != kNoFacet) return false;
  return true;
}

/// What is left out, no direction within the limit clears by brute force; where the tool leans and does not
/// turn, none that leans less by a degree does.
class LeanLimits : public ::testing::TestWithParam<double> {};

TEST_P(LeanLimits, LeansLeastOfAllDirectionsAndNothingIsLeftOutForWant) {
  const CheckedMesh part = bowl();
  PlanOptions o = leaning_options(kUpright, GetParam());
  o.pattern.side_step = 2.0;
  const Plan made = planned(part, o), plain = planned(part, without_guards(o));
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid tool(o.cutter);
  std::vector<Vec3> directions;
  for (const Vec3 d : even_directions(samples(40'000)))
    if (d.z >= std::cos(o.lean.limit.radians())) directions.push_back(d);
  const auto none_clear = [&](const Pose& pose, double most) {
    return std::none_of(directions.begin(), directions.end(), [&](Vec3 axis) {
      return axis.z > std::cos(most) && stands_clear(tool, surface, centre_of(pose, o), axis, o);
    });
  };
  const std::vector<CutRun> kept = runs_of(made.path);
  std::vector<CutRun> centres = kept;
  for (CutRun& run : centres)
    for (Pose& pose : run) pose.tip = centre_of(pose, o);
  std::size_t left = 0;
  for (const CutRun& run : dense(runs_of(plain.path), 1.0))
    for (const Pose& pose : run) {
      if (from_runs(centre_of(pose, o), centres) < 0.8) continue;
      ++left;
      EXPECT_TRUE(none_clear(pose, o.lean.limit.radians())) << pasteable(pose);
    }
  // On and off it leans more than the place itself asks for.
  std::vector<double> excess;
  for (const CutRun& run : kept)
    for (const Pose& pose : run)
      if (const double lean = lean_of(pose, o); lean > 1.5 * kDegree) {
        double least = lean;
        for (const Vec3 axis : directions)
          if (axis.z > std::cos(least) && stands_clear(tool, surface, centre_of(pose, o), axis, o))
            least = std::acos(axis.z);
        excess.push_back(lean - least);
      }
  EXPECT_EQ(left > 0, GetParam() < 10.0);
  EXPECT_GT(excess.size(), 20u);
  EXPECT_LT(median(excess), 0.4 * kDegree);
  EXPECT_LT(*std::max_element(excess.begin(), excess.end()), 1.6 * kDegree);
}

INSTANTIATE_TEST_SUITE_P(Degrees, LeanLimits, ::testing::Values(4.0, 8.0, 25.0));

struct ModeCase {
  const char* name;
  AxisFrame axis;
  Grid grid;  ///< of the sheet, in the mode's coordinates
  double level;
};

std::vector<ModeCase> mode_cases() {
  const auto frame = [](AxisMode mode, Sense sense, double radius) {
    return AxisFrame{mode, sense, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, radius};
  };
  return {
      {"fixed", frame(AxisMode::kFixed, Sense::kOutward, 0.0), {-24, 24, -24, 24, 48, 48}, 0.0},
      {"point_outside", frame(AxisMode::kPoint, Sense::kOutward, 0.0), {-0.4, 0.4, -0.4, 0.4, 48, 48}, 60.0},
      {"point_inside", frame(AxisMode::kPoint, Sense::kInward, 0.0), {-0.4, 0.4, -0.4, 0.4, 48, 48}, -60.0},
      {"line_outside", frame(AxisMode::kLine, Sense::kOutward, 0.0), {-24, 24, -0.4, 0.4, 48, 48}, 60.0},
      {"line_inside", frame(AxisMode::kLine, Sense::kInward, 0.0), {-24, 24, -0.4, 0.4, 48, 48}, -60.0},
      {"circle_outside",
       frame(AxisMode::kCircle, Sense::kOutward, 30.0),
       {-0.25, 0.25, -0.4, 0.4, 48, 48},
       60.0}};
}

class LeanModes : public ::testing::TestWithParam<std::tuple<ModeCase, CutterType>> {};

TEST_P(LeanModes, KeepTheToolClearAndLeaveLessThanTrimming) {
  const ModeCase& mode = std::get<0>(GetParam());
  const CutterType type = std::get<1>(GetParam());
  const double half_u = mode.grid.u1, half_v = mode.grid.v1;
  // A pit whose walls the holder does not pass, and a tower beside it.
  const CheckedMesh part = sheet(mode.axis, mode.grid, [&](double u, double v) {
    const double x = 24.0 * u / half_u, y = 24.0 * v / half_v;
    const double tower = std::clamp(3.0 * (5.0 - std::max(std::abs(x - 14.0), std::abs(y - 4.0))), 0.0, 9.0);
    return mode.level - 22.0 * std::exp(-(x * x + y * y) / (2.0 * 8.0 * 8.0)) + 2.0 * tower;
  });
  PlanOptions o = leaning_options(mode.axis, 30.0);
  o.pattern.side_step = 2.5, o.find_rest_material = true;
  if (type == CutterType::kTaperBall)
    o.cutter.type = type, o.cutter.taper = Angle::from_degrees(4.0), o.cutter.shank_diameter = 0.0;
  const Plan made = planned(part, o), trimmed = planned(part, trimming(o));
  ASSERT_TRUE(made.report.lean);
  EXPECT_GT(made.report.lean->length, 5.0);
  expect_within_limits(made.path, o);
  expect_clear(part, made.path, o);
  EXPECT_LT(made.report.uncut->area, trimmed.report.uncut->area);
}

INSTANTIATE_TEST_SUITE_P(Modes, LeanModes,
                         ::testing::Combine(::testing::ValuesIn(mode_cases()),
                                            ::testing::Values(CutterType::kBall, CutterType::kTaperBall)),
                         [](const auto& one) {
                           return std::string(std::get<0>(one.param).name) +
                                  (std::get<1>(one.param) == CutterType::kBall ? "_ball" : "_taper");
                         });

/// A jaw as high as the holder is in the way of: a fixture leans the tool, and is told by its name where it
/// still keeps the tool off.
TEST(Lean, GivesWayToAFixture) {
  const CheckedMesh part = drawn_along_x({{0, 0}, {40, 0}});
  PlanOptions o = leaning_options(kUpright, 50.0);
  o.find_rest_material = true;
  Fixtures jaw;
  jaw.mesh = box_mesh({{Vec3{0, -20, -10}, {60, -1, 40}}}), jaw.names = {"jaw"};
  jaw.mesh.source.assign(jaw.mesh.facets.size(), 0);
  o.fixtures = std::make_shared<const Fixtures>(jaw), o.fixture_room = {0.2, 0.4, 0.6};
  const Plan made = planned(part, o), trimmed = planned(part, trimming(o));
  // The side that the jaw holds is 600 mm2 large.
  EXPECT_LT(made.report.uncut->fixture_area[0] - 600.0,
            0.3 * (trimmed.report.uncut->fixture_area[0] - 600.0));
  expect_within_limits(made.path, o);
  expect_clear(part, made.path, o);
  CheckedMesh body;
  body.mesh = jaw.mesh;
  for (const Point<Part>& v : jaw.mesh.vertices) body.bounds = grown(body.bounds, v);
  PlanOptions keeps = o;
  keeps.holder.clearance = o.fixture_room.holder, keeps.shank.clearance = o.fixture_room.shank;
  expect_clear(body, made.path, keeps);
  std::size_t leaning = 0;
  for (const CutRun& run : dense(runs_of(made.path), 1.0))
    for (const Pose& pose : run) {
      const Point<Part> c = centre_of(pose, o);
      if (c.x < 20.0 || c.x > 40.0) continue;
      const double need = needed_lean(8.6, 17.4, c.y + 1.0), lean = lean_of(pose, o);
      EXPECT_GE(lean, need - 0.05 * kDegree) << pasteable(pose);
      EXPECT_LE(lean, need + 0.4 * kDegree) << pasteable(pose);
      leaning += need > 0.0 ? 1 : 0;
    }
  EXPECT_GT(leaning, 50u);
}

/// What a cone cuts it would leave: there the tool does not lean.
TEST(Lean, DoesNotTakeAConeOffTheWallThatItCuts) {
  // A wall of 80 degrees that a cone of 10 cuts with its side, under a step that the holder meets.
  const CheckedMesh part = sheet(kUpright, {-20, 20, -6, 6, 200, 1}, [](double u, double) {
    return std::clamp((u - 4.0) * std::tan(80.0 * kDegree), 0.0, 30.0);
  });
  PlanOptions o = leaning_options(kUpright, 40.0);
  o.cutter.type = CutterType::kTaperBall, o.cutter.taper = Angle::from_degrees(10.0);
  o.cutter.cutting_length = 14.0, o.cutter.shank_diameter = 0.0;
  const Plan made = planned(part, o);
  expect_clear(part, made.path, o);
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid tool(o.cutter);
  std::size_t leaning = 0;
  for (const CutRun& run : runs_of(made.path))
    for (const Pose& pose : run) {
      if (lean_of(pose, o) < 0.1 * kDegree) continue;
      ++leaning;
      // The ball touches.
      EXPECT_LE(std::abs(surface.nearest(centre_of(pose, o)).value - o.cutter.radius()), o.tolerance)
          << pasteable(pose);
    }
  EXPECT_GT(leaning, 0u);
}

/// A wide holder low on the tool dips under the ball's centre when the tool leans. The tool turns upright
/// over the clearance surface: only where that is as high as the holder dips there is a way.
TEST(Lean, AnEndHasAWayOnlyWhereTheToolCanTurnUpright) {
  const CheckedMesh part = drawn_along_x({{0, 0}, {40, 0}});
  PlanOptions o = leaning_options(kUpright, 50.0);
  o.cutter = {4.0, 100.0, 8.0};
  o.cutter.holder = {{40.0, 40.0, 30.0}};
  const double lean = 30.0 * kDegree, dip = 20.5 * std::sin(lean) - 5.5 * std::cos(lean);
  ASSERT_GT(dip, 3.0);
  const Deformation map(kUpright, 1.0);
  EnvelopePoint end;
  end.centre = {30.0, 8.0, 2.0}, end.flat = map.flatten(end.centre);
  end.axis = {0.0, std::sin(lean), std::cos(lean)}, end.normal = {0, 0, 1};
  for (const double spare : {-0.3, 0.3}) {
    const LeanTool tool(part.mesh, o, map, dip + spare);
    EXPECT_EQ(leaned_end(tool, end).has_value(), spare > 0.0) << spare;
  }
}

/// Leans are the same to the last bit for those that need none, and the frame goes there and back.
TEST(LeanStations, ALeanIsWhatTheAxisMakesOfIt) {
  const AxisFrame axis{AxisMode::kPoint, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};
  const Deformation map(axis, 50.0);
  Pass pass;
  for (int i = 0; i < 20; ++i) {
    EnvelopePoint p;
    p.flat = {2.0 * i, 0.3 * i * i, 50.0 + i};
    const AxisLine line = map.axis_line(p.flat.x, p.flat.y);
    p.centre = line.base + line.axis * p.flat.z, p.axis = line.axis;
    pass.push_back(p);
  }
  const PassFrames frames(pass, map);
  for (double run = 0.0; run <= frames.length(); run += 0.37) {
    const LeanStation s = frames.at(run);
    EXPECT_EQ(s.axis({}), s.point.axis);
    EXPECT_NEAR(dot(s.first, s.point.axis), 0.0, 1e-12);
    for (const LeanAngle lean : {LeanAngle{0.3, -0.1}, {0.0, 0.7}, {-0.5, 0.5}}) {
      EXPECT_NEAR(angle_between(s.axis(lean), s.point.axis), lean.size(), 1e-12);
      const LeanAngle back = s.lean_of(s.axis(lean));
      EXPECT_NEAR(back.u, lean.u, 1e-12);
      EXPECT_NEAR(back.v, lean.v, 1e-12);
      const LeanAngle other{0.1, 0.2};
      EXPECT_NEAR(angle_between(s.axis(lean), s.axis(other)),
                  angle_between(LeanStation::direction(lean), LeanStation::direction(other)), 1e-12);
    }
  }
}

}  // namespace
}  // namespace tiltfeed
