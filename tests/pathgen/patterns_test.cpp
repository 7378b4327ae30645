// Patterns, directions, point spacing and bad input of plan(), by closed forms of a cone and a dome.
#include "pathgen/pattern/pattern.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/judges/path_proof.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

// (pattern.h, property 1)
TEST(Patterns, ContoursOfAConeAreCircles) {
  const double foot = 12.0, height = 18.0, slope = std::atan2(height, foot), r = 2.0;
  const CheckedMesh part = turned({{0, height}, {foot, 0}, {0, 0}}, 240);
  PlanOptions o = options_with(kUpright);
  o.pattern.kind = PatternKind::kZLevel;
  o.pattern.step_down = 1.5;
  const double flats = foot * (1.0 - std::cos(kPi / 240.0));  // between the cone and its facets
  std::set<double> levels;
  for (const CutRun& run : runs_of(part, o)) {
    const double z = run.front().tip.z + r;
    for (const Pose& pose : run) EXPECT_NEAR(pose.tip.z + r, z, 1e-6);
    // Above, the ball rolls over the cone's tip, below over its foot.
    if (z < r * std::cos(slope) || z > height + r * std::cos(slope)) continue;
    const double want = ((height - z) * std::cos(slope) + r) / std::sin(slope);
    for (const CutRun& fine : dense(std::vector<CutRun>{run}, 0.2))
      for (const Pose& pose : fine)
        EXPECT_NEAR(std::hypot(pose.tip.x, pose.tip.y), want, flats + 2 * o.tolerance);
    EXPECT_LT(distance(run.front().tip, run.back().tip), 1e-6);
    levels.insert(std::round(z * 1e6));
  }
  EXPECT_GE(levels.size(), 12u);  // 18 mm of cone in levels at most 1.5 mm apart
  for (auto it = levels.begin(); std::next(it) != levels.end(); ++it)
    EXPECT_LE(*std::next(it) - *it, 1.5e6 + 2.0);
}

// (pattern.h, property 2)
TEST(Patterns, NoLevelIsOnTheAxisFeatureItself) {
  // Beside a block the contours of a containment go on down; on the line or point itself no axis is defined,
  // and what goes up from there would go up along any.
  constexpr double kLeast = 0.1;
  for (const AxisMode mode : {AxisMode::kLine, AxisMode::kPoint, AxisMode::kCircle}) {
    const double radius = mode == AxisMode::kCircle ? 7.0 : 0.0;
    PlanOptions o = options_with({mode, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, radius});
    const CheckedMesh part = turned({{0, 9}, {6, 9}, {6, 6}, {0, 6}}, 24);
    o.pattern.kind = PatternKind::kZLevel;
    o.pattern.side_step = 2.0, o.pattern.step_down = 4.0;
    o.containment.height = {0.0, 20.0};
    const auto planned = plan(part, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    const Deformation map(o.axis, 1.0);
    double lowest = kPi * 1e3;
    const std::vector<Move>& moves = planned->path.moves;
    for (std::size_t i = 1; i < moves.size(); ++i) {
      const Pose& pose = moves[i].pose;
      lowest = std::min(lowest, map.distances(pose.tip + pose.axis * o.cutter.radius()).rho);
      // Up from the end of a pass, along the axis that the tool has there.
      if (moves[i - 1].kind == MoveKind::kCut && moves[i].kind != MoveKind::kCut) {
        EXPECT_LT(angle_between(moves[i - 1].pose.axis, pose.axis), 1e-6) << static_cast<int>(mode);
      }
    }
    EXPECT_NEAR(lowest, kLeast, 0.1 * kLeast) << static_cast<int>(mode);
    const Measured m =
        PathProof(o.axis, o.pattern.along, o.cutter, o.tolerance, part, planned->path).measure(1);
    EXPECT_LE(m.rapid_overlap, o.tolerance);
    EXPECT_LE(m.gouge, o.tolerance);
  }
}

/// A dome of radius 15 round the origin, in the upper half space.
constexpr double kDome = 15.0;
CheckedMesh dome() {
  std::vector<std::array<double, 2>> profile;
  for (int i = 0; i < 45; ++i) {
    const double polar = kPi / 2.0 * i / 44;
    profile.push_back({i == 0 ? 0.0 : kDome * std::sin(polar), kDome * std::cos(polar)});
  }
  profile.push_back({0.0, 0.0});
  profile[44][1] = 0.0;
  return turned(profile, 120);
}

// (pattern.h, property 3)
TEST(Patterns, ASplitCutsWallsByLevelsAndTheRestByRows) {
  PlanOptions o = options_with(kUpright);
  const double r = o.cutter.radius(), split = kPi / 4.0;
  o.pattern.kind = PatternKind::kSplit;
  o.pattern.side_step = 1.0;
  o.pattern.step_down = 0.7;  // 1 mm along a surface of 45 degrees, nearly
  o.pattern.measure = StepMeasure::kSurface;
  const auto runs = runs_of(dome(), o);
  // A facet's slope differs from the dome's by half a row of facets; the overlap is along a pass.
  const double slack = kPi / 2.0 / 44 + o.pattern.side_step / (kDome + r);
  std::size_t rows = 0, contours = 0;
  for (const CutRun& run : runs) {
    const auto level = [&](const Pose& p) { return std::abs(p.tip.z - run.front().tip.z) < 1e-6; };
    const bool contour = run.size() > 4 && std::all_of(run.begin(), run.end(), level);
    ++(contour ? contours : rows);
    for (const Pose& pose : run) {
      const Vec3 centre = from_origin(pose.tip) + pose.axis * r;
      if (centre.z < 0.0) continue;
      const double slope = std::acos(std::min(1.0, centre.z / length(centre)));
      EXPECT_GT(contour ? slope : split, split - slack);
      EXPECT_LT(contour ? split : slope, split + slack);
    }
  }
  EXPECT_GT(rows, 10u);
  EXPECT_GT(contours, 5u);
  double widest = 0.0;
  for (double polar = 0.02; polar < 1.45; polar += 0.02)
    for (double turn = 0.0; turn < 2.0 * kPi; turn += 0.05) {
      const Vec3 n{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
      widest = std::max(widest, from_runs(Point<Part>{} + (n * (kDome + r) - Vec3{0, 0, r}), runs));
    }
  EXPECT_LE(widest, 1.05 * o.pattern.side_step / 2.0);
}

TEST(Patterns, BadInputIsRefusedByName) {
  const CheckedMesh part = sheet(kUpright, {-5, 5, -5, 5, 1, 1}, [](double, double) { return 0.0; });
  const auto refused = [&](const PlanOptions& o, Code code, const char* key) {
    const auto planned = plan(part, o, nullptr);
    ASSERT_FALSE(planned);
    EXPECT_EQ(planned.error().code, code) << planned.error().message;
    EXPECT_NE(planned.error().message.find(key), std::string::npos) << planned.error().message;
  };
  PlanOptions o = options_with(kUpright);
  o.pattern.kind = PatternKind::kZLevel;
  refused(o, Code::kInput, "pattern.step_down_mm");
  o = options_with(kUpright), o.pattern.side_step = 0.0;
  for (StepMeasure measure : {StepMeasure::kFlat, StepMeasure::kSurface}) {
    o.pattern.measure = measure, o.pattern.side_step = 0.0;
    refused(o, Code::kInput, "pattern.side_step_mm");
    o.pattern.side_step = 1e-6;
    refused(o, Code::kLimit, "pattern.side_step_mm");
  }
  o = options_with(kUpright), o.pattern.measure = StepMeasure::kScallop;
  refused(o, Code::kInput, "pattern.scallop_mm");
  o.pattern.scallop = 0.05, o.cutter.type = CutterType::kFlat;
  refused(o, Code::kInput, "pattern.measure");
}

TEST(Patterns, ASideStepWiderThanThePartGivesOnePass) {
  const CheckedMesh part = sheet(kUpright, {-5, 5, -5, 5, 1, 1}, [](double, double) { return 0.0; });
  PlanOptions o = options_with(kUpright);
  for (StepMeasure measure : {StepMeasure::kFlat, StepMeasure::kSurface}) {
    o.pattern.measure = measure, o.pattern.side_step = 40.0;
    EXPECT_EQ(runs_of(part, o).size(), 1u);
  }
}

TEST(Patterns, RowsAreStraightInTheirDirection) {
  for (const AxisFrame& axis : {kUpright, kRing}) {
    PlanOptions o = options_with(axis);
    o.pattern.angle = Angle::from_degrees(30.0);
    const Deformation map(axis, 1.0);
    const auto flat = [&](const Pose& p) {
      const Point<Flat> f = map.flatten(p.tip);
      return Vec3{f.x / map.scale_x(), f.y / map.scale_y(), 0.0};
    };
    // Own coordinates are the flat ones but for their scales, so a ring's rows have one direction, too.
    Vec3 way = axis.mode == AxisMode::kFixed ? Vec3{std::cos(kPi / 6.0), std::sin(kPi / 6.0), 0.0} : Vec3{};
    const auto runs = runs_of(slab(axis), o);
    ASSERT_GT(runs.size(), 12u);
    for (const CutRun& run : runs) {
      const Vec3 chord = flat(run.back()) - flat(run.front());
      if (length(chord) * (axis.mode == AxisMode::kFixed ? 1.0 : kGroundRadius) < 1.0) continue;
      if (way == Vec3{}) way = normalized(chord);
      EXPECT_GT(dot(way, way), 0.5);
      for (const Pose& pose : run) {
        const Vec3 d = flat(pose) - flat(run.front());
        EXPECT_LT(length(d - way * dot(d, way)), 1e-8);
      }
    }
    if (axis.mode == AxisMode::kCircle) {  // atan2(R Phi, (Ri + R) Theta) for R near the slab's mean radius
      EXPECT_NEAR(std::atan2(way.y * (kGroundRadius + 3.0), way.x * (60.0 + kGroundRadius + 3.0)), kPi / 6.0,
                  0.03);
    }
  }
}

/// The longest cutting move on the slab, mm of the ball's centre, and the widest turn of its axis, rad. Where
/// `walls` are left out, moves up and down walls along the axis do not count.
std::pair<double, double> largest_moves(const PlanOptions& o, bool walls) {
  constexpr double kAside = 0.01;  // no more than this aside, mm, is a wall
  std::pair<double, double> found{0.0, 0.0};
  for (const CutRun& run : runs_of(slab(o.axis), o))
    for (std::size_t i = 1; i < run.size(); ++i) {
      const Pose &a = run[i - 1], &b = run[i];
      const Vec3 d = (b.tip + b.axis * o.cutter.radius()) - (a.tip + a.axis * o.cutter.radius());
      found.second = std::max(found.second, angle_between(a.axis, b.axis));
      if (walls || length(d - b.axis * dot(d, b.axis)) > kAside)
        found.first = std::max(found.first, length(d));
    }
  return found;
}

void expect_near_points(const AxisFrame& axis, PatternKind kind, bool walls) {
  PlanOptions o = options_with(axis);
  o.pattern.kind = kind, o.pattern.step_down = 1.0;
  EXPECT_GT(largest_moves(o, walls).first, 0.5);
  o.max_point_distance = 0.3;
  o.max_angle_step = Angle::from_degrees(0.2);
  const auto [longest, turn] = largest_moves(o, walls);
  EXPECT_LE(longest, o.max_point_distance + 1e-9);
  EXPECT_LE(turn, o.max_angle_step.radians() + 1e-9);
}

// (pattern.h, property 4)
TEST(Patterns, RowsHavePointsAsNearAsAsked) {
  for (const AxisFrame& axis : {kUpright, kRing}) expect_near_points(axis, PatternKind::kRaster, false);
}

// (pattern.h, property 4)
TEST(Patterns, RowsHavePointsAsNearAsAskedOnWallsToo) {
  for (const AxisFrame& axis : {kUpright, kRing}) expect_near_points(axis, PatternKind::kRaster, true);
}

// (pattern.h, property 4)
TEST(Patterns, ContoursHavePointsAsNearAsAsked) {
  for (const AxisFrame& axis : {kUpright, kRing}) expect_near_points(axis, PatternKind::kZLevel, true);
}

}  // namespace
}  // namespace tiltfeed
