// The judges of interference and cover, against closed forms and seeded faults, before any planner is held
// against them.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/judges/free_cover.h"
#include "tests/judges/tool_proof.h"
#include "tests/shapes/turned_parts.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kTolerance = 0.01;
constexpr double kNear = 0.006;  ///< chords of the rings and of the ball's facets, mm

Cutter ball(double diameter, double shank_length) { return {diameter, 2 * shank_length, shank_length}; }

Angle degrees(double value) { return Angle::from_degrees(value); }

/// Rings round a ball of 10 mm from pole to pole, the axis along the normal, safe above the part between
/// them.
struct Rings {
  static constexpr double kPartRadius = 10.0, kBall = 2.0;
  static constexpr int kCount = 32;   ///< rings, of equal distance on the ball
  static constexpr int kTurns = 150;  ///< cuts of a ring: they leave 0.003 mm to the true ring
  CheckedMesh part = solid_ball(kPartRadius, 80);
  sim::PartDistance distances{part.mesh};
  Cutter cutter = ball(2 * kBall, 40);
  ToolPath path;
  double step() const { return kPi * (kPartRadius + kBall) / kCount; }

  static Pose pose(double polar, double turn, double above) {
    const Vec3 n{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
    return {Point<Part>{} + n * (kPartRadius + above), n};
  }
  Rings() {
    for (int ring = 0; ring < kCount; ++ring) {
      const double polar = kPi * (ring + 0.5) / kCount;
      path.moves.push_back({pose(polar, 0, 5), MoveKind::kRapid});
      path.moves.push_back({pose(polar, 0, 0), MoveKind::kPlunge});
      for (int k = 1; k <= kTurns; ++k)
        path.moves.push_back({pose(polar, 2 * kPi * k / kTurns, 0), MoveKind::kCut});
      path.moves.push_back({pose(polar, 0, 5), MoveKind::kRapid});
    }
  }
  ToolFindings measured(std::array<double, 3> clearance = {}) const {
    return ToolProof(distances, part.bounds, cutter, kTolerance, clearance).measure(path, 0.1);
  }
  FreeCoverage covered(Angle tilt_max = degrees(180.0)) const {
    const ReachOptions o{.cutter = cutter, .tilt_max = tilt_max, .directions = 200};
    const Reach reach(distances, part.bounds, o);
    return FreeCover(part.mesh, distances, reach, {{0, 0, 1}}, PassStep::kSurface, step(), kTolerance)
        .cover(path, 1500);
  }
  /// The first cut of a ring.
  std::size_t first_cut(int ring) const { return static_cast<std::size_t>(ring) * (kTurns + 3) + 2; }
};

TEST(ToolProof, PassesASafePath) {
  const ToolFindings found = Rings().measured();
  EXPECT_LE(found.gouge(), kNear);
  EXPECT_LE(found.contact.value, kNear);
  EXPECT_EQ(found.buried, 0u);
  EXPECT_GT(found.cut_poses, 5'000u);
  EXPECT_GT(found.link_poses, 300u);
}

TEST(ToolProof, FindsOneAxisTurnedIntoThePart) {
  Rings rings;
  Move& move = rings.path.moves[rings.first_cut(9) + 70];
  const Vec3 sideways = normalized(cross(move.pose.axis, {0, 0, 1}));
  const Point<Part> centre = move.pose.tip + move.pose.axis * Rings::kBall;
  move.pose.axis = rotation_about(sideways, 110.0 * kPi / 180.0) * move.pose.axis;
  move.pose.tip = centre - move.pose.axis * Rings::kBall;
  const ToolFindings found = rings.measured();
  // The axis runs 20 degrees past the tangent: its foot is 12 sin 110 from the middle.
  EXPECT_NEAR(found.gouge(), 12.0 - 12.0 * std::sin(110.0 * kPi / 180.0), 0.05);
  EXPECT_NEAR(static_cast<double>(found.cut[0].move), static_cast<double>(rings.first_cut(9) + 70), 1.0);
}

TEST(ToolProof, FindsALiftedPoint) {
  Rings rings;
  Pose& pose = rings.path.moves[rings.first_cut(20) + 7].pose;
  pose.tip = pose.tip + pose.axis * 0.05;
  const ToolFindings found = rings.measured();
  EXPECT_NEAR(found.contact.value, 0.05, kNear);
  EXPECT_EQ(found.contact.move, rings.first_cut(20) + 7);
  EXPECT_LE(found.gouge(), kNear);
}

TEST(ToolProof, FindsALinkThroughThePart) {
  Rings rings;
  rings.path.moves.push_back({Rings::pose(kPi / 2, 0, 5), MoveKind::kRapid});
  rings.path.moves.push_back({Rings::pose(kPi / 2, 3.0, 5), MoveKind::kRapid});
  const ToolFindings found = rings.measured();
  EXPECT_GT(found.link[0].value, 1.0);
  EXPECT_EQ(found.link[0].move, rings.path.moves.size() - 1);
  EXPECT_LE(found.cut[0].value, kNear);
}

TEST(ToolProof, FindsShankAndHolderEachByItself) {
  Rings rings;
  rings.cutter.cutting_length = 6, rings.cutter.shank_length = 8, rings.cutter.shank_diameter = 3.0;
  rings.cutter.holder = {{30, 30, 20}};
  EXPECT_LE(rings.measured({0, 1.0, 1.0}).gouge(), kNear);
  Move& move = rings.path.moves[rings.first_cut(16) + 60];
  // Leaning by this much the holder's face, 6 mm up from the ball's centre, is 12 cos + 6 from the middle.
  const double lean = 75.0 * kPi / 180.0;
  const Point<Part> centre = move.pose.tip + move.pose.axis * Rings::kBall;
  move.pose.axis = rotation_about(normalized(cross(move.pose.axis, {0, 0, 1})), lean) * move.pose.axis;
  move.pose.tip = centre - move.pose.axis * Rings::kBall;
  const ToolFindings found = rings.measured();
  EXPECT_NEAR(found.cut[2].value, 10.0 - 6.0 - 12.0 * std::cos(lean), 0.01);
  EXPECT_LE(found.cut[0].value, kNear);
  EXPECT_EQ(found.cut[1].value, 0.0);
  EXPECT_NEAR(static_cast<double>(found.cut[2].move), static_cast<double>(rings.first_cut(16) + 60), 1.0);
}

TEST(ToolProof, AsksForTheClearance) {
  Rings rings;
  rings.cutter.cutting_length = 6, rings.cutter.shank_diameter = 3.0;
  const ToolFindings found = rings.measured({0, 7.0, 0});
  // The shank starts 6 mm above the part.
  EXPECT_NEAR(found.cut[1].value, 1.0, 0.01);
}

TEST(ToolProof, FindsAToolInsideTheMaterial) {
  Rings rings;
  rings.cutter = ball(1, 5);
  rings.path.moves.clear();
  for (int k = 0; k < 3; ++k)
    rings.path.moves.push_back({{{0.1 * k, 0, -2}, {0, 0, 1}}, k == 0 ? MoveKind::kRapid : MoveKind::kCut});
  EXPECT_EQ(rings.measured().buried, 2u);
}

TEST(FreeCover, SeesAWholeFinish) {
  const FreeCoverage c = Rings().covered();
  EXPECT_EQ(c.reachable, 1500u);
  EXPECT_GE(c.share(), 0.999) << c.worst_at.x << ", " << c.worst_at.y << ", " << c.worst_at.z << " by "
                              << c.worst_excess;
  EXPECT_LE(c.border + c.shallow, 30u);
}

TEST(FreeCover, FindsAPassThatIsNotThere) {
  for (const int missing : {3, 16, 25}) {
    Rings rings;
    const auto first = rings.path.moves.begin() + static_cast<std::ptrdiff_t>(rings.first_cut(missing)) - 2;
    rings.path.moves.erase(first, first + Rings::kTurns + 3);
    const FreeCoverage c = rings.covered();
    const double polar = std::acos(c.worst_at.z / Rings::kPartRadius);
    EXPECT_NEAR(polar, kPi * (missing + 0.5) / Rings::kCount, 0.5 * kPi / Rings::kCount);
    // Two steps apart: in the middle (s^2 / 2) / R' is left of which (s^2 / 8) / R' was to be.
    const auto must = [&](double half) {
      const double turn = half / (Rings::kPartRadius + Rings::kBall);
      const double in = Rings::kPartRadius, out = in + Rings::kBall;
      return std::sqrt(in * in + out * out - 2 * in * out * std::cos(turn)) - Rings::kBall;
    };
    EXPECT_NEAR(c.worst_excess, must(rings.step()) - must(rings.step() / 2) - kTolerance, 0.02);
    // The ring's share of the surface, of which all but the parts beside the next rings is uncut.
    const double band = std::sin(kPi * (missing + 0.5) / Rings::kCount) * kPi / Rings::kCount;
    EXPECT_GT(1.0 - c.share(), 0.3 * band) << missing;
    EXPECT_LT(1.0 - c.share(), 1.3 * band) << missing;
  }
}

/// What a tilt limit hides is not asked for: some rings suffice where the rest is out of reach.
TEST(FreeCover, AsksOnlyForWhatIsInReach) {
  Rings rings;
  rings.path.moves.resize(rings.first_cut(24) - 2);  // three quarters of the way down
  const FreeCoverage all = rings.covered();
  EXPECT_NEAR(all.share(), (1.0 - std::cos(kPi * 24 / 32)) / 2.0, 0.03);
  const FreeCoverage some = rings.covered(degrees(35.0));
  EXPECT_LT(some.reachable, all.reachable);
  EXPECT_GE(some.share(), 0.99);
}

}  // namespace
}  // namespace tiltfeed
