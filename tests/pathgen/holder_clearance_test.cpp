// Shank and holder kept clear by each reaction, against the tool's true solid on the planned path.
#include "pathgen/pattern/holder_clearance.h"

#include <gtest/gtest.h>

#include "sim/solid/tool_solid.h"
#include "tests/samples.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// A floor before a wall 20 mm high, and a tool whose holder is as wide as the wall is near.
struct Shop {
  CheckedMesh part = sheet(kUpright, {-20, 20, -6, 6, 80, 1},
                           [](double u, double) { return std::clamp((u - 9.9) * 100.0, 0.0, 20.0); });
  sim::PartDistance surface{part.mesh};
  PlanOptions plain = options_with(kUpright), guarded = plain;
  Cutter tool;

  explicit Shop(Reaction reaction) {
    plain.cutter = {4.0, 100.0, 12.0};
    plain.max_point_distance = 0.25;
    guarded = plain;
    guarded.cutter.holder = {{16.0, 20.0, 30.0}};
    guarded.holder = {0.5, reaction};
    tool = guarded.cutter;
  }
  bool clear(const Pose& pose) const {
    return sim::ToolSolid(tool).clearance(surface, pose, sim::ToolPart::kHolder, 2.0).value >=
           guarded.holder.clearance - guarded.tolerance;
  }
  /// Share of the length of the moves on which the holder is clear, and that length.
  std::pair<double, double> clear_length(const std::vector<CutRun>& runs) const {
    double all = 0.0, good = 0.0;
    for (const CutRun& run : dense(runs, 0.25))
      for (std::size_t i = 1; i < run.size(); ++i) {
        const double size = distance(run[i - 1].tip, run[i].tip);
        all += size, good += clear(run[i - 1]) && clear(run[i]) ? size : 0.0;
      }
    return {good / all, good};
  }
  static bool warns(const Plan& planned) {
    return std::any_of(planned.report.warnings.begin(), planned.report.warnings.end(), [](const auto& w) {
      return w.find("holder") != std::string::npos && w.find("facet") != std::string::npos;
    });
  }
};

TEST(Guards, TrimmingLeavesNoHolderContactAndNoMoreOutThanThat) {
  const Shop shop(Reaction::kTrim);
  const auto plain = shop.clear_length(runs_of(shop.part, shop.plain));
  ASSERT_LT(plain.first, 0.9);
  const auto planned = plan(shop.part, shop.guarded, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_TRUE(Shop::warns(*planned));
  const auto trimmed = shop.clear_length(runs_of(planned->path));
  EXPECT_EQ(trimmed.first, 1.0);
  EXPECT_NEAR(trimmed.second, plain.second, 0.03 * plain.second);
}

/// Between a high and a low wall. The smoothed pass of the cutter alone is so high that the holder would pass
/// over the low one; it is not, once the high wall has cut the pass off.
TEST(Guards, TrimmingIsJudgedBeforeCornersAreSmoothed) {
  Shop shop(Reaction::kTrim);
  const CheckedMesh trough = sheet(kUpright, {-20, 20, -6, 6, 80, 1}, [](double u, double) {
    return u < 0.0 ? std::clamp((-9.9 - u) * 300.0, 0.0, 60.0) : std::clamp((u - 9.9) * 100.0, 0.0, 18.0);
  });
  shop.surface = sim::PartDistance(trough.mesh);
  shop.guarded.smoothing = 30.0;
  const auto planned = plan(trough, shop.guarded, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  const auto [share, clear] = shop.clear_length(runs_of(planned->path));
  EXPECT_EQ(share, 1.0);
  EXPECT_GT(clear, 60.0);
}

/// A foot whose outline dips inwards by `dip` between its 24 corners, turned by `twist` (rad). The column on
/// it has flats `column` inside the straight lines between those corners, and shorter than they are.
CheckedMesh dipping_foot(double dip, double column, double twist) {
  constexpr std::size_t kCorners = 24, kOnSide = 4, kAround = kCorners * kOnSide;
  const double radius = 4.0, turn = kPi / kCorners, chord = radius * std::cos(turn);
  // Of a side, from its corner: the corner, a place, the middle and the place opposite to the first.
  const std::array<double, kOnSide> share{-0.5, -0.35, 0.0, 0.35}, foot{0.0, 0.3 * dip, dip, 0.3 * dip};
  const auto on_side = [&](std::size_t k, bool is_foot, double z) {
    const std::size_t i = k % kOnSide;
    const double half = radius * std::sin(turn),
                 across = twist + turn * (2.0 * static_cast<double>(k / kOnSide) + 1.0);
    const double out = is_foot ? chord - foot[i] : chord - column - (i == 0 ? 0.05 : 0.0);
    const double along = 2.0 * half * share[i];
    return Point<Part>{out * std::cos(across) - along * std::sin(across),
                       out * std::sin(across) + along * std::cos(across), z};
  };
  const auto at = [&](std::size_t ring, std::size_t k) -> Point<Part> {
    if (ring == 0) return {0.0, 0.0, 25.0};
    if (ring == 5) return {0.0, 0.0, 0.0};
    return on_side(k % kAround, ring >= 3, ring == 1 ? 25.0 : ring == 4 ? 0.0 : 5.0);
  };
  Shell shell;
  for (std::size_t ring = 0; ring < 5; ++ring)
    for (std::size_t k = 0; k < kAround; ++k)
      shell.quad(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1));
  return shell.checked();
}

/// The cutting part touches all along a contour, not only at its points.
TEST(Guards, ATrimmedContourHasNoMoveOnWhichTheShankAloneTouches) {
  PlanOptions o = options_with(kUpright);
  o.cutter.type = CutterType::kFlat;
  o.cutter.diameter = 2.0, o.cutter.cutting_length = 7.0, o.cutter.shank_diameter = 2.4;
  o.shank = {0.3, Reaction::kTrim};
  o.pattern.kind = PatternKind::kZLevel;
  o.pattern.step_down = 2.5;
  const sim::ToolSolid tool(o.cutter);
  std::size_t poses = 0;
  for (int k = 0; k < samples(20); ++k) {  // the grid meets the foot elsewhere each time
    const CheckedMesh part = dipping_foot(3.0 * o.tolerance, 0.5, 0.013 * k);
    const sim::PartDistance surface(part.mesh);
    for (const CutRun& run : dense(runs_of(part, o), 0.02))
      for (const Pose& pose : run) {
        if (pose.tip.z < 0.5 || pose.tip.z > 4.5) continue;
        ++poses;
        EXPECT_LE(tool.clearance(surface, pose, sim::ToolPart::kCutter, 1.0).value, o.tolerance * 1.0001)
            << to_string(pose.tip);
      }
  }
  EXPECT_GT(poses, std::size_t{samples(100)});
}

/// A groove that the cutting part fits into and the shank does not, between rows of 8 mm.
struct Groove {
  CheckedMesh part = sheet(kUpright, {-20, 20, -12, 12, 2, 480},
                           [](double, double v) { return std::abs(v) < 2.52 ? 0.0 : 15.0; });
  sim::PartDistance surface{part.mesh};
  PlanOptions slim = options_with(kUpright);
  std::size_t low = 0, poses = 0;

  Groove() {
    slim.cutter = {4.0, 100.0, 40.0};
    slim.cutter.cutting_length = 8.0;
    slim.containment.first = {-15.0, 15.0};
    slim.pattern.side_step = 8.0;
  }
  /// Counts poses of the slim tool in the groove. The shank of the wide one keeps clear, wherever rows lie.
  void hold() {
    for (const double aside : {0.0, 1.0, 2.0, 3.0, 4.0}) {
      slim.containment.second = {-8.0 + aside, 8.0 + aside};
      PlanOptions wide = slim;
      wide.cutter.shank_diameter = 5.2, wide.shank = {0.0, Reaction::kTrim};
      const sim::ToolSolid tool(wide.cutter);
      for (const CutRun& run : dense(runs_of(part, slim), 0.2))
        for (const Pose& pose : run) low += pose.tip.z < 1.0 ? 1 : 0;
      for (const CutRun& run : dense(runs_of(part, wide), 0.2))
        for (const Pose& pose : run) {
          ++poses;
          EXPECT_GE(tool.clearance(surface, pose, sim::ToolPart::kShank, 1.0).value, -slim.tolerance)
              << to_string(pose.tip);
        }
    }
  }
};

/// No pass comes down there, a join would.
TEST(Guards, AJoinGoesNoLowerThanShankAndHolderAreKnown) {
  Groove groove;
  groove.slim.links.join_distance = 10.0, groove.slim.links.clearance = 300.0;
  groove.hold();
  EXPECT_GT(groove.low, 10u);
  EXPECT_GT(groove.poses, 500u);
}

TEST(Guards, RetractingKeepsAllColumnsAndRaisesTheTool) {
  const Shop shop(Reaction::kRetract);
  const auto plain = runs_of(shop.part, shop.plain);
  const auto planned = plan(shop.part, shop.guarded, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_TRUE(Shop::warns(*planned));
  const auto raised = runs_of(planned->path);
  EXPECT_EQ(shop.clear_length(raised).first, 1.0);
  double highest = 0.0;
  for (const CutRun& run : plain)
    for (const Pose& pose : run) {
      if (std::abs(pose.tip.x) > 20.0 || std::abs(pose.tip.y) > 6.0) continue;  // beside the part
      double aside = std::numeric_limits<double>::infinity(), lift = -aside;
      for (const CutRun& other : raised)
        for (std::size_t i = 1; i < other.size(); ++i) {
          const Point<Part> a = other[i - 1].tip, b = other[i].tip;
          const Vec3 ab{b.x - a.x, b.y - a.y, 0}, ap{pose.tip.x - a.x, pose.tip.y - a.y, 0};
          const double f =
              squared_length(ab) > 0 ? std::clamp(dot(ab, ap) / squared_length(ab), 0.0, 1.0) : 0;
          const double d = length(ap - ab * f), z = a.z + (b.z - a.z) * f - pose.tip.z;
          if (d < aside - 1e-9 || (d < aside + 1e-9 && z > lift)) aside = d, lift = z;
        }
      EXPECT_LT(aside, 1e-6);
      EXPECT_GT(lift, -2.0 * shop.plain.tolerance);
      highest = std::max(highest, lift);
    }
  EXPECT_NEAR(highest, 20.0 - 12.0 + 0.5, 0.1);  // the holder's lower end half a millimetre over the wall
}

TEST(Guards, ReportingChangesNothingButTheReport) {
  const Shop shop(Reaction::kReport);
  const auto plain = plan(shop.part, shop.plain, nullptr), guarded = plan(shop.part, shop.guarded, nullptr);
  ASSERT_TRUE(plain && guarded);
  EXPECT_FALSE(Shop::warns(*plain));
  EXPECT_TRUE(Shop::warns(*guarded));
  ASSERT_EQ(plain->path.moves.size(), guarded->path.moves.size());
  for (std::size_t i = 0; i < plain->path.moves.size(); ++i) {
    EXPECT_EQ(plain->path.moves[i].pose, guarded->path.moves[i].pose);
    EXPECT_EQ(plain->path.moves[i].kind, guarded->path.moves[i].kind);
  }
}

TEST(Guards, RetractingAddsNoColumnsThatTheCutterDoesNotReach) {
  const Shop shop(Reaction::kRetract);
  // Round the part's corners the cutter's columns end on an arc.
  for (const CutRun& run : dense(runs_of(shop.part, shop.guarded), 0.2))
    for (const Pose& pose : run) {
      const double x = std::max(0.0, std::abs(pose.tip.x) - 20.0);
      const double y = std::max(0.0, std::abs(pose.tip.y) - 6.0);
      EXPECT_LE(std::hypot(x, y), 2.0 + 0.01) << pose.tip.x << " " << pose.tip.y << " " << pose.tip.z;
    }
}

// The tool climbs a slope with a ridge across it. Between where the holder's lower rim is over the slope's
// reach and where it is over the ridge, the ridge stands in its way for a few hundredths of a millimetre.
TEST(Guards, AConicalHolderStepIsRaisedOverWhatItsLowerRimMeets) {
  constexpr double kSlope = 2.0, kRidge = 8.0, kColumn = 0.5, kBall = 3.0;
  for (int i = 0; i < 24; ++i) {
    const double rim = 5.5 + 0.05 * i, way = 0.01 + 0.003 * i;
    const double cone = std::tan((4.0 + 0.5 * i) * kPi / 180.0);
    const double over = 2.0 + kSlope * rim;  // from tip to holder
    // The tip where the rim comes to the ridge.
    const double tip = kSlope * (kRidge - rim) + kBall * std::hypot(1.0, kSlope) - kBall;
    const CheckedMesh part = sheet(kUpright, {-8, 24, -3, 3, 64, 1}, [&](double u, double) {
      return std::abs(u - kRidge) < kColumn / 2 ? tip + over + way : kSlope * u;
    });
    PlanOptions options = options_with(kUpright);
    options.cutter = {2.0 * kBall, 120.0, over};
    options.cutter.holder = {{2.0 * rim, 2.0 * (rim + 8.0 * cone), 8.0}};
    options.holder = {0.0, Reaction::kRetract};
    options.containment.first = {-3.0, 4.0}, options.containment.second = {-2.0, 2.0};
    const auto planned = plan(part, options, nullptr);
    ASSERT_TRUE(planned) << planned.error().message;
    const sim::PartDistance surface(part.mesh);
    const sim::ToolSolid tool(options.cutter);
    for (const CutRun& run : dense(runs_of(planned->path), 0.01))
      for (const Pose& pose : run)
        ASSERT_GE(tool.clearance(surface, pose, sim::ToolPart::kHolder, 1.0).value, -options.tolerance)
            << "case " << i << " at " << pose.tip.x << " " << pose.tip.y;
  }
}

}  // namespace
}  // namespace tiltfeed
